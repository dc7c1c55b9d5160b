"""Strands over time as a table."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hairpipe.data import Strands, Table
from hairpipe.data.table import table_of_rows
from hairpipe.measure.writhe import writhe

COLUMNS = (
    "time [s]",
    "strand",
    "tip x [m]",
    "tip y [m]",
    "tip z [m]",
    "span [m]",
    "stretch [%]",
    "segment strain [%]",
    "fastest point [m/s]",
    "writhe [1]",
    "moved [mm]",
)


def measure(hair: Mapping[int, Strands], fps: float) -> Table:
    """Return a row for every frame and strand; time zero, and what moved and stretched is compared to, is the first.

    span            from root to tip
    stretch         of the whole strand
    segment strain  the largest, whether stretched or compressed
    writhe          loops, see `writhe`
    moved           root mean square over the points
    """
    frames = iter(hair)
    start = next(frames)
    first = hair[start]
    rows = list(rows_of(first, first, 0.0))
    for frame in frames:
        rows += rows_of(hair[frame], first, (frame - start) / fps)
    return table_of_rows(COLUMNS, rows)


def rows_of(now: Strands, first: Strands, time: float) -> Iterator[tuple[Any, ...]]:
    """Measure every strand at one frame."""
    for strand, (begin, end) in enumerate(zip(now.offsets, now.offsets[1:], strict=False)):
        points, before = (hair.points[begin:end].astype(float) for hair in (now, first))
        lengths, rest = (np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (points, before))
        yield (
            time,
            strand,
            *points[-1].tolist(),
            np.linalg.norm(points[-1] - points[0]),
            100.0 * (lengths.sum() / rest.sum() - 1.0),
            100.0 * np.abs(lengths / rest - 1.0).max(),
            np.linalg.norm(now.velocities[begin:end], axis=1).max(),
            writhe(points),
            1e3 * np.sqrt(np.mean(np.sum((points - before) ** 2, axis=1))),
        )
