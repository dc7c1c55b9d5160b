"""A helix cut into equal segments, and the turn of a curve that was."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.units import Ge, Gt, Metres

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
