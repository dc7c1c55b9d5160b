"""Radii of curls."""

from collections.abc import Mapping

import numpy as np

from hairpipe.data import Strands, Table
from hairpipe.data.table import table_of_columns
from hairpipe.errors import BadInput


def measure_radii(hair: Mapping[int, Strands], fps: float) -> Table:
    """Return the radius of the curls at every frame, and what it is of that at the first; time zero is the first frame.

    curl radius  mean distance of the points from the centre line of their strand, over all strands that curl
    smallest     mean of the strand where it is least
    Raise BadInput where no strand makes a whole turn at the first frame.
    """
    frames = list(hair)
    first = hair[frames[0]]
    strands = list(zip(first.offsets, first.offsets[1:], strict=False))
    turns = [turn_of(first.points[begin:end].astype(float)) for begin, end in strands]
    curled = [(range_, turn) for range_, turn in zip(strands, turns, strict=True) if turn <= range_[1] - range_[0] - 2]
    if not curled:
        raise BadInput("no strand makes a whole turn", where="hair", right="curls, at the first frame")
    radii = np.array(
        [[radius(hair[f].points[begin:end].astype(float), turn) for (begin, end), turn in curled] for f in frames]
    )
    means = radii.mean(axis=1)
    return table_of_columns(
        {
            "time [s]": (np.array(frames) - frames[0]) / fps,
            "curl radius [mm]": 1e3 * means,
            "smallest [mm]": 1e3 * radii.min(axis=1),
            "of the first [%]": 100.0 * means / means[0],
        }
    )


def turn_of(points: np.ndarray) -> float:
    """Return how many segments of a curve, (n, 3), make a turn, on the median; inf where it is straight.

    The bend from one segment to the next points to the axis: it turns about that by the same angle every segment.
    """
    bends = np.diff(points, 2, axis=0)
    sizes = np.linalg.norm(bends, axis=1)
    if len(bends) < 2 or not (sizes > 1e-6 * np.linalg.norm(points[1] - points[0])).all():
        return float("inf")
    cosines = np.sum(bends[1:] * bends[:-1], axis=1) / (sizes[1:] * sizes[:-1])
    angle = float(np.median(np.arccos(np.clip(cosines, -1.0, 1.0))))
    return 2.0 * np.pi / angle if angle > 0.0 else float("inf")


def radius(points: np.ndarray, turn: float) -> float:
    """Return the mean distance of a curve, (n, 3), from its mean over one turn about each point, as far as that goes.

    turn  segments
    """
    at = np.arange(len(points))
    middle = at[(at >= 0.5 * turn) & (at <= at[-1] - 0.5 * turn)]
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(0.5 * (points[1:] + points[:-1]), axis=0)])

    def integral(place: np.ndarray) -> np.ndarray:
        k = np.minimum(place.astype(int), len(points) - 2)
        s = (place - k)[:, None]
        return sums[k] + s * points[k] + 0.5 * s**2 * (points[k + 1] - points[k])

    centres = (integral(middle + 0.5 * turn) - integral(middle - 0.5 * turn)) / turn
    return float(np.linalg.norm(points[middle] - centres, axis=1).mean())
