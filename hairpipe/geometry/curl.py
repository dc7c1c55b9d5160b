"""A helix cut into equal segments, and the turn of a curve that was.

The axis of hair is for a curl the line that it winds about, for other hair the hair itself. The tangent of a curl
rotates about its axis, so the axis defines its direction. The axis at a point is the mean of the curve over one turn
about it; within half a turn of an end it is extrapolated along its tangent.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.units import Ge, Gt, Metres
from hairpipe.values import Groom

HALVINGS = 60  # of the interval that holds the turn: down to rounding


@dataclass(frozen=True)
class Helix:
    """A right-handed helix along the direction of the strand; the root lies on the helix.

    radius  radius of the helix about its axis
    pitch   advance of the helix along its axis per turn
    """

    radius: Annotated[Metres, Gt(0.0)]
    pitch: Annotated[Metres, Ge(0.0)]


def wound(curl: Helix, length: float, segments: int) -> np.ndarray:
    """Return points on a helix along the third axis, (segments + 1, 3) [m], by chords of length / segments.

    The turn t of a chord c solves c^2 = (2 R sin(t / 2))^2 + (P t / 2 pi)^2, which grows with t up to half a turn.
    """

    def chord(turn: float) -> float:
        return np.hypot(2.0 * curl.radius * np.sin(turn / 2.0), curl.pitch * turn / (2.0 * np.pi))

    low = 0.0
    high = np.pi
    wanted = length / segments
    if chord(high) < wanted:
        fewest = int(np.ceil(length / chord(high)))
        raise BadInput(f"{segments} segments are more than half a turn each", right=f"segments >= {fewest}")
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if chord(middle) < wanted else (low, middle)
    turns = low * np.arange(segments + 1)
    around = curl.radius * np.column_stack([np.cos(turns) - 1.0, np.sin(turns)])
    return np.column_stack([around, curl.pitch * turns / (2.0 * np.pi)])


def turn_of(points: np.ndarray) -> float:
    """Return the number of segments per turn of a curve, (n, 3), the median; inf if it is straight.

    The bend from one segment to the next points to the axis, and rotates about it by the same angle every segment.
    """
    bends = np.diff(points, 2, axis=0)
    sizes = np.linalg.norm(bends, axis=1)
    if len(bends) < 2 or not (sizes > 1e-6 * np.linalg.norm(points[1] - points[0])).all():
        return float("inf")
    cosines = np.sum(bends[1:] * bends[:-1], axis=1) / (sizes[1:] * sizes[:-1])
    angle = float(np.median(np.arccos(np.clip(cosines, -1.0, 1.0))))
    return 2.0 * np.pi / angle if angle > 0.0 else float("inf")


def centres_of(points: np.ndarray, turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean of a curve, (n, 3), over one turn about each point, and the points that have one; pure.

    turn  number of segments per turn
    """
    at = np.arange(len(points))
    middle = at[(at >= 0.5 * turn) & (at <= at[-1] - 0.5 * turn)]
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(0.5 * (points[1:] + points[:-1]), axis=0)])

    def integral(place: np.ndarray) -> np.ndarray:
        k = np.minimum(place.astype(int), len(points) - 2)
        s = (place - k)[:, None]
        return sums[k] + s * points[k] + 0.5 * s**2 * (points[k + 1] - points[k])

    return (integral(middle + 0.5 * turn) - integral(middle - 0.5 * turn)) / turn, middle


def axes_of(groom: Groom) -> np.ndarray:
    """Return the axes of all strands, point by point [m], (p, 3) float64; pure."""
    axes = groom.points.copy()
    for begin, end in zip(groom.offsets[:-1], groom.offsets[1:], strict=True):
        turn = turn_of(groom.points[begin:end])
        if 2.0 < turn <= end - begin - 2:
            centres, middle = centres_of(groom.points[begin:end], turn)
            axis = axes[begin:end]
            at = np.arange(len(axis))
            axis[middle] = centres
            way = (centres[-1] - centres[0]) / max(len(middle) - 1, 1)
            before = at[: middle[0]]
            after = at[middle[-1] + 1 :]
            axis[before] = centres[0] - (middle[0] - before)[:, None] * way
            axis[after] = centres[-1] + (after - middle[-1])[:, None] * way
    return axes


def curls_of(groom: Groom) -> np.ndarray:
    """Return the strands that are curls of one turn or more, (n,) int64; pure.

    Their total turning is at least one turn, and they wind about an axis.
    """
    ways = np.diff(groom.points, axis=0)
    units = ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), np.finfo(float).tiny)
    angles = np.arccos(np.clip(np.sum(units[1:] * units[:-1], axis=1), -1.0, 1.0))
    inner = np.ones(len(groom.points), bool)
    inner[groom.offsets[:-1]] = inner[groom.offsets[1:] - 1] = False
    strands = np.repeat(np.arange(len(groom.ids)), np.diff(groom.offsets))[1:-1]
    bends = np.bincount(strands, np.where(inner[1:-1], angles, 0.0), len(groom.ids))
    ends = [(k, groom.offsets[k], groom.offsets[k + 1]) for k in np.flatnonzero(bends >= 2.0 * np.pi)]
    found = [k for k, begin, end in ends if 2.0 < turn_of(groom.points[begin:end]) <= end - begin - 1]
    return np.array(found, np.int64)
