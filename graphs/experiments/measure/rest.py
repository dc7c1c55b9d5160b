"""Hair at rest: its drift, its reported speed, and its distance from a known shape."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import Strands, Table
from hairpipe.values.groom import strand_lengths
from hairpipe.values.table import table_of_rows

COLUMNS = ("drift [mm]", "speed [mm/s]", "reported speed [mm/s]", "difference of speeds [mm/s]", "error [% of length]")


def rest_table(hair: Mapping[int, Strands], truth: Strands | None, fps: float, seconds: float) -> Table:
    """Return one row about the last seconds: the largest values over points and frames.

    drift                 distance from the position at the last frame
    speed                 displacement from frame to frame over the time between them
    reported speed        of the velocities that strands have
    difference of speeds  distance of the reported velocity from the displacement over the time
    error                 distance from the truth at the last frame, over the length of the shortest strand; NaN without

    BadInput where the hair has fewer frames, or `seconds` are less than one.
    """
    count = round(seconds * fps)
    if not 0 < count < len(hair):
        what = f"{seconds:g} s are {count} frames of {len(hair)}"
        raise BadInput(what, where="seconds", right="at least a frame, and at most the duration of the hair")
    frames = list(hair)[-1 - count :]
    last = hair[frames[-1]]
    end = last.points.astype(float)
    drift, reported, speed, apart = 0.0, 0.0, 0.0, 0.0
    for before, now in pairwise([hair[frame] for frame in frames]):
        moved = fps * (now.points.astype(float) - before.points)
        drift = max(drift, largest(before.points - end))
        speed = max(speed, largest(moved))
        reported = max(reported, largest(now.velocities))
        apart = max(apart, largest(now.velocities - moved))
    error = np.nan
    if truth is not None:
        length = float(strand_lengths(truth.points, truth.offsets).min())
        error = 100.0 * largest(end - truth.points) / length
    return table_of_rows(COLUMNS, [(1e3 * drift, 1e3 * speed, 1e3 * reported, 1e3 * apart, error)])


def largest(vectors: np.ndarray) -> float:
    """Return the largest length of vectors, (n, 3)."""
    return float(np.linalg.norm(vectors, axis=1).max())
