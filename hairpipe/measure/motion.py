"""Speed, stretch and height of all hair, frame by frame."""

from collections.abc import Mapping, Sequence

import numpy as np

from hairpipe.data import Groom, Strands, Table
from hairpipe.data.lengths import strand_lengths
from hairpipe.data.table import table_of_rows

COLUMNS = (
    "time [s]",
    "rms speed [mm/s]",
    "fastest [mm/s]",
    "longest stretch [%]",
    "mean height [mm]",
    "moved [mm]",
    "moved farthest [mm]",
)


def measure_speeds(hair: Mapping[int, Strands], fps: float, cuts: Sequence[int] = ()) -> Table:
    """Return a row for every frame, over all points but the roots, which are prescribed; time zero is the first frame.

    rms speed, fastest  of the points
    longest stretch     largest stretch of a whole strand, over its length at the first frame
    mean height         along Y
    moved               rms displacement since the previous frame; 0 at a cut of the shot
    moved farthest      largest displacement since the previous frame, likewise
    """
    frames = list(hair)
    first = previous = hair[frames[0]]
    roots = first.offsets[:-1]
    lengths = strand_lengths(first.points, first.offsets)
    rows = []
    for frame in frames:
        now = hair[frame]
        previous = now if frame in cuts else previous
        points, before = (np.delete(strands.points.astype(float), roots, axis=0) for strands in (now, previous))
        moved = np.linalg.norm(points - before, axis=1)
        displacements = 1e3 * np.sqrt(np.mean(moved**2)), 1e3 * moved.max()
        rows.append(((frame - frames[0]) / fps, *row_of(now, lengths), *displacements))
        previous = now
    return table_of_rows(COLUMNS, rows)


def watch(hair: Strands, groom: Groom) -> Table:
    """Return the row of `measure_speeds` of one frame, with the stretch against the groom."""
    return table_of_rows(COLUMNS[1:-2], [row_of(hair, strand_lengths(groom.points, groom.offsets))])


def row_of(hair: Strands, lengths: np.ndarray) -> tuple[float, ...]:
    """Return speeds, stretch over lengths [m], (S,), and height of hair."""
    roots = hair.offsets[:-1]
    speeds = np.linalg.norm(np.delete(hair.velocities.astype(float), roots, axis=0), axis=1)
    return (
        1e3 * np.sqrt(np.mean(speeds**2)),
        1e3 * speeds.max(),
        100.0 * (strand_lengths(hair.points, hair.offsets) / lengths - 1.0).max(),
        1e3 * np.delete(hair.points.astype(float), roots, axis=0)[:, 1].mean(),
    )
