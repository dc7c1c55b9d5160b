"""Slip of hair relative to the rigid motion of its roots."""

from collections.abc import Mapping

import numpy as np

from hairpipe.values import Ends, Strands, Table
from hairpipe.values.table import table_of_rows

COLUMNS = ("time [s]", "strand", "slope [1]", "tip slipped [mm]", "slipped [mm]")


def measure_slips(hair: Mapping[int, Strands], ends: Mapping[int, Ends], fps: float) -> Table:
    """Return a row for every frame and strand, against where the motion of the root takes the first frame.

    slope        tangent of the tilt of what was level at the first frame
    tip slipped  of the tip
    slipped      root mean square over all points
    """
    frames = list(hair)
    first = hair[frames[0]]
    start = ends[frames[0]].roots
    rows = []
    for frame in frames:
        turn = ends[frame].roots[:, :, :3] @ start[:, :, :3].transpose(0, 2, 1)
        shift = ends[frame].roots[:, :, 3] - np.einsum("sij,sj->si", turn, start[:, :, 3])
        for strand, (begin, end) in enumerate(zip(first.offsets, first.offsets[1:], strict=False)):
            expected = first.points[begin:end].astype(float) @ turn[strand].T + shift[strand]
            away = 1e3 * np.linalg.norm(hair[frame].points[begin:end] - expected, axis=1)
            upright = float(turn[strand, 1, 1])
            slope = np.sqrt(max(1.0 - upright**2, 0.0)) / upright if upright > 0.0 else np.inf
            rows.append(((frame - frames[0]) / fps, strand, slope, away[-1], np.sqrt(np.mean(away**2))))
    return table_of_rows(COLUMNS, rows)
