"""Motion by keys: where to and how far turned, at given times."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.scripted_ends.rigid_paths import Course, Vector, unit
from hairpipe.units import Degrees, Metres, Seconds

Shift = tuple[Metres, Metres, Metres]
INSTANT = 1e-9  # [s]; times closer than this are the same


@dataclass(frozen=True)
class Track:
    """Key-framed motion of an end from its place in the groom, constant before the first and after the last key.

    times  times of the keys, ascending
    move   displacement at each key; if absent, zero
    turn   rotation about the axis at each key; if absent, zero
    axis   axis of the rotations
    pivot  vector from the end to a point of the axis
    ease   interpolation between keys: smooth has zero speed at every key, linear has constant speed
    """

    times: tuple[Seconds, ...] = ()
    move: tuple[Shift, ...] = ()
    turn: tuple[Degrees, ...] = ()
    axis: Vector = (1.0, 0.0, 0.0)
    pivot: Shift = (0.0, 0.0, 0.0)
    ease: Literal["smooth", "linear"] = "smooth"

    def __post_init__(self) -> None:
        """Raise BadInput where keys do not belong together, or the axis has no length."""
        unit(self.axis, "axis")
        if any(after - before <= INSTANT for before, after in pairwise(self.times)):
            raise BadInput(f"times = {list(self.times)}", right="ascending times")
        for name, keys in (("move", self.move), ("turn", self.turn)):
            if keys and len(keys) != len(self.times):
                what = f"{name} has {len(keys)} keys, times has {len(self.times)}"
                raise BadInput(what, right="one for every time, or none at all")


def instant_of(frame: int, at: int, fps: float, cuts: Sequence[int]) -> float:
    """Return the time of a frame [s], an instant into its take where the shot is cut next to it; pure.

    at    frame at which time is zero
    cuts  frames at which the shot is cut

    A track that jumps between the two frames around a cut has the speed of its take there, not the mean of both sides.
    """
    return (frame - at) / fps + 2.0 * INSTANT * ((frame in cuts) - (frame + 1 in cuts))


def course_of(track: Track, time: float) -> Course:
    """Find how far an end is moved and turned at a time [s]; where the speed jumps it is the mean of both sides."""
    count = len(track.times)
    move = np.reshape(track.move or np.zeros((count, 3)), (count, 3))
    turn = np.radians(track.turn or np.zeros(count))
    keys = np.column_stack([move, turn])
    sides = [piece(track, keys, time, time + shift) for shift in (-INSTANT, INSTANT)]
    place, rate = np.mean(sides, axis=0)
    return Course(place[:3], rate[:3], place[3], rate[3])


def piece(track: Track, keys: np.ndarray, time: float, side: float) -> tuple[np.ndarray, np.ndarray]:
    """Return value and rate at a time, on the piece between two keys (n, 4) that holds the time `side`."""
    k = int(np.searchsorted(track.times, side))
    if not len(keys):
        return np.zeros(4), np.zeros(4)
    if k in (0, len(keys)):
        return keys[max(k - 1, 0)], np.zeros(4)
    span = track.times[k] - track.times[k - 1]
    way = keys[k] - keys[k - 1]
    u = (time - track.times[k - 1]) / span
    s, speed = (u, 1.0) if track.ease == "linear" else (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u))
    return keys[k - 1] + s * way, speed / span * way
