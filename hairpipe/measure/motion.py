"""Speed, stretch and height of all hair, frame by frame."""

from collections.abc import Mapping

import numpy as np

from hairpipe.data import Strands, Table
from hairpipe.data.lengths import strand_lengths
from hairpipe.data.table import table_of_rows

COLUMNS = ("time [s]", "rms speed [mm/s]", "fastest [mm/s]", "longest stretch [%]", "mean height [mm]", "moved [mm]")


def measure_speeds(hair: Mapping[int, Strands], fps: float) -> Table:
    """Return a row for every frame, over all points but the roots, which are led; time zero is the first frame.

    rms speed, fastest  of the points; half the square of the first is the kinetic energy of a kilogram
    longest stretch     of a whole strand, over its length at the first frame
    mean height         along Y
    moved               root mean square, since the frame before
    """
    frames = list(hair)
    first = previous = hair[frames[0]]
    led, lengths, rows = first.offsets[:-1], strand_lengths(first.points, first.offsets), []
    for frame in frames:
        now = hair[frame]
        points, before = (np.delete(strands.points.astype(float), led, axis=0) for strands in (now, previous))
        speeds = np.linalg.norm(np.delete(now.velocities.astype(float), led, axis=0), axis=1)
        moved = np.linalg.norm(points - before, axis=1)
        rows.append(
            (
                (frame - frames[0]) / fps,
                1e3 * np.sqrt(np.mean(speeds**2)),
                1e3 * speeds.max(),
                100.0 * (strand_lengths(now.points, now.offsets) / lengths - 1.0).max(),
                1e3 * points[:, 1].mean(),
                1e3 * np.sqrt(np.mean(moved**2)),
            )
        )
        previous = now
    return table_of_rows(COLUMNS, rows)
