"""Motion by keys, and to and fro, of the ends of strands and of rigid bodies.

Motions are rigid, x -> R x + t, of many points at once, (S, 3, 4), each with its rate of change.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Literal, NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.units import Degrees, DegreesPerSecond, Gt, Metres, MetresPerSecond, PerSecond, Seconds
from hairpipe.values import BodyParts, Ends, Groom, LevelSet, Mesh
from hairpipe.values.body import gathered

Vector = tuple[float, float, float]


class Motion(NamedTuple):
    """Motions, and their derivative by time [1/s, m/s]; columns of R and then t, (S, 3, 4) each."""

    place: np.ndarray
    rate: np.ndarray


class Course(NamedTuple):
    """Motion along and about an axis at one time: shift [m], its rate [m/s], turn [rad], its rate [rad/s]."""

    shift: np.ndarray
    shift_rate: np.ndarray
    turn: float
    turn_rate: float


def unit(vector: Vector, name: str) -> np.ndarray:
    """Scale a vector to length 1; BadInput for a zero vector."""
    length = np.linalg.norm(vector)
    if not length > 0.0:
        raise BadInput(f"{name} = {list(vector)} has no length", right="any other vector")
    return np.array(vector) / length


def turned(course: Course, axis: np.ndarray, pivots: np.ndarray) -> Motion:
    """Turn about an axis through every pivot, (S, 3) [m], and shift: x -> R (x - p) + p + s.

    R = I + sin(a) K + (1 - cos(a)) K^2 (Rodrigues), K y = axis x y; R' = a' K R.
    """
    K = np.cross(np.eye(3), axis)
    R = np.eye(3) + np.sin(course.turn) * K + (1.0 - np.cos(course.turn)) * K @ K
    dR = course.turn_rate * K @ R
    return Motion(
        with_shift(R, pivots - pivots @ R.T + course.shift), with_shift(dR, course.shift_rate - pivots @ dR.T)
    )


def with_shift(turn: np.ndarray, shifts: np.ndarray) -> np.ndarray:
    """Put a matrix (3, 3) and shifts (S, 3) side by side, (S, 3, 4)."""
    turns = np.broadcast_to(turn, (len(shifts), 3, 3))
    return np.concatenate([turns, shifts[:, :, None]], axis=2)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Multiply the matrices of one, (S, 3, 4), with all columns of the other."""
    return np.einsum("sij,sjk->sik", a[:, :, :3], b)


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
        unit(self.axis, "axis")
        if any(late - early <= INSTANT for early, late in pairwise(self.times)):
            raise BadInput(f"times = {list(self.times)}", right="ascending times")
        for name, keys in (("move", self.move), ("turn", self.turn)):
            if keys and len(keys) != len(self.times):
                what = f"{name} has {len(keys)} keys, times has {len(self.times)}"
                raise BadInput(what, right="one for every time, or none at all")


def instant_of(frame: int, at: int, fps: float, cuts: Sequence[int]) -> float:
    """Return the time of a frame since `at` [s], just inside its take where the shot is cut next to it.

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


Swing = tuple[Metres, Metres, Metres]
CLOSE = 1e-9  # in half waves: closer to where a square wave turns round it stands


@dataclass(frozen=True)
class Wave:
    """Periodic motion from rest at time zero, in addition to keys.

    form       form of the velocity: sine, or square of constant speed and alternating sign
    frequency  frequency of the oscillation
    speed      maximum speed of the end
    along      direction of the first half period
    turning    maximum angular speed about the axis
    axis       axis of the rotations
    pivot      vector from the end to a point of the axis
    """

    form: Literal["sine", "square"] = "sine"
    frequency: Annotated[PerSecond, Gt(0.0)] = 2.0
    speed: MetresPerSecond = 0.0
    along: Vector = (1.0, 0.0, 0.0)
    turning: DegreesPerSecond = 0.0
    axis: Vector = (0.0, 1.0, 0.0)
    pivot: Swing = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        unit(self.along, "along")
        unit(self.axis, "axis")


def course_of_wave(wave: Wave, time: float) -> Course:
    """Find how far an end is moved and turned at a time [s]."""
    time = max(time, 0.0)
    phase = wave.frequency * time
    if wave.form == "sine":
        angle = 2.0 * np.pi * phase
        seconds = (1.0 - np.cos(angle)) / (2.0 * np.pi * wave.frequency)
        share = np.sin(angle)
    else:
        within = phase % 1.0
        turns = abs(2.0 * phase - round(2.0 * phase)) < CLOSE
        seconds = min(within, 1.0 - within) / wave.frequency
        share = 0.0 if turns else 1.0 if within < 0.5 else -1.0
    velocity = wave.speed * unit(wave.along, "along")
    turning = np.radians(wave.turning)
    return Course(seconds * velocity, share * velocity, seconds * turning, share * turning)


def drive(
    groom: Groom, time: float, roots: Track, wave: Wave | None, tips: Track | None, release: float | None
) -> Ends:
    """Return the ends at a time [s].

    roots    motion of the roots, and the wave in the frame that it moves
    tips     motion of the tips; free without
    release  time after which the tips are free [s]
    """
    first = groom.points[groom.offsets[:-1]]
    last = groom.points[groom.offsets[1:] - 1]
    root = follow(roots, first, time)
    if wave:
        course = course_of_wave(wave, time)
        inner = turned(course, unit(wave.axis, "axis"), first + np.array(wave.pivot))
        place = product(root.place, inner.place)  # (A B)' = A' B + A B'
        place[:, :, 3] += root.place[:, :, 3]
        rate = product(root.rate, inner.place) + product(root.place, inner.rate)
        rate[:, :, 3] += root.rate[:, :, 3]
        root = Motion(place, rate)
    held = tips if release is None or time <= release + 3.0 * INSTANT else None
    tip = Motion(*np.full((2, *root.place.shape), np.nan)) if held is None else follow(held, last, time)
    return Ends(root.place, root.rate, tip.place, tip.rate)


def follow(track: Track, ends: np.ndarray, time: float) -> Motion:
    """Move ends, (S, 3) [m], along a track."""
    return turned(course_of(track, time), unit(track.axis, "axis"), ends + np.array(track.pivot))


NAME = "body"


def moved(mesh: Mesh, track: Track, time: float) -> Mesh:
    """Return a mesh moved by keys at a time [s], with the exact velocities of that motion.

    The pivot of the track is a place in space; the mesh may move by itself, too.
    """
    place, rate = (motion[0] for motion in follow(track, np.zeros((1, 3)), time))
    points = mesh.points @ place[:, :3].T + place[:, 3]
    velocities = mesh.points @ rate[:, :3].T + rate[:, 3]
    if mesh.velocities is not None:
        velocities += mesh.velocities @ place[:, :3].T
    return Mesh(points, mesh.triangles, velocities, mesh.uv)


def moved_surface(surface: LevelSet, track: Track, time: float) -> BodyParts:
    """Return the level set of a body where keys take it at a time [s], as a body of one part.

    Raises BadInput where the body is not at rest, too: its level set would have to be baked at every frame.
    """
    if surface.velocity.any():
        right = "the level set of a mesh at rest, before it is moved"
        raise BadInput("the body is not at rest", where="in.surface", right=right)
    place, rate = follow(track, np.zeros((1, 3)), time)
    return gathered((NAME,), place, rate, [surface])
