"""A bar in the path of a tuft: the motions of both, and which strands passed through the bar."""

from functools import lru_cache

import numpy as np

from hairpipe.body.scripted_motion import Track, Wave, course_of_wave, drive
from hairpipe.body.shapes import build_cylinder
from hairpipe.groom.settings import Tuft
from hairpipe.groom.strands import gather_tuft, lay_strands
from hairpipe.levelset.bake import bake
from hairpipe.values import BodyParts, Ends, Groom
from hairpipe.values.body import LevelSet, gathered

LENGTH, SEGMENTS, COLUMNS, ROWS, APART, STRAY = 0.2, 20, 8, 4, 1.5e-3, 4.0
"""Length of the strands [m], their number in x and z, the distance between roots [m], and their scatter [deg]."""
RADIUS, WIDTH, BELOW, VOXEL = 0.015, 1.0, 0.08, 0.0025
"""Radius of the bar, its length along z, the depth of its axis below the roots, and its voxel [m]."""
FREQUENCY, ASIDE = 2.0, 0.25
"""Frequency of both motions [1/s]; speed of the roots, which move along the bar, over the speed of the bar."""
HALT = 1.0 / FREQUENCY
"""Time at which both are where they began, and stay [s]."""


def tuft() -> Groom:
    """Lay the strands, which hang, about the origin."""
    row = lay_strands(COLUMNS, LENGTH, SEGMENTS, (0.0, -1.0, 0.0), (APART, 0.0, 0.0), None, 0.0)
    return gather_tuft(row, Tuft(ROWS, (0.0, 0.0, APART), STRAY))


def roots_at(groom: Groom, speed: float, time: float) -> Ends:
    """Lead the roots along the bar and back, at a time [s]; speed of the bar [m/s]."""
    wave = Wave(frequency=FREQUENCY, speed=ASIDE * speed, along=(0.0, 0.0, 1.0))
    return drive(groom, min(time, HALT), Track(), wave, None, None)


def axis_at(speed: float, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a point of the axis of the bar [m] and its velocity [m/s], (3,) each.

    It is below the middle of the roots when it is fastest: a quarter of a period after the start, and on the way back.
    """
    course = course_of_wave(Wave(frequency=FREQUENCY, speed=speed, along=(-1.0, 0.0, 0.0)), min(time, HALT))
    begins = speed / (2.0 * np.pi * FREQUENCY) + 0.5 * (COLUMNS - 1) * APART
    return np.array([begins, -BELOW, 0.5 * (ROWS - 1) * APART]) + course.shift, course.shift_rate


def bar_at(speed: float, time: float) -> BodyParts:
    """Return the bar at a time [s], a body of one part."""
    place, rate = axis_at(speed, time)
    pose = np.column_stack([np.eye(3), place])
    rates = np.column_stack([np.zeros((3, 3)), rate])
    return gathered(("bar",), pose[None], rates[None], [_shape()])


@lru_cache(maxsize=1)
def _shape() -> LevelSet:
    return bake(build_cylinder(RADIUS, WIDTH, False, 96, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), VOXEL, 8.0)


def depth(points: np.ndarray) -> float:
    """Return how deep the deepest of points is in the bar [m]; points from its axis [m], (P, 3)."""
    aside = np.abs(points[:, 2]) < 0.5 * WIDTH
    return float(np.where(aside, RADIUS - np.hypot(points[:, 0], points[:, 1]), 0.0).max(initial=0.0))


def passed_through(before: np.ndarray, after: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Mark the strands of which a segment went across the axis of the bar, all points going straight, (S,) bool.

    before, after  points from that axis at two times [m], (P, 3); offsets of the strands, (S+1,)
    """
    first = np.arange(len(before) - 1)
    turns = went_across(before, after, np.column_stack([first, first + 1]))
    turns[offsets[1:-1] - 1] = False
    return np.add.reduceat(np.append(turns, False), offsets[:-1]) > 0


def went_across(before: np.ndarray, after: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """Mark the segments, (n, 2), that went across the axis of the bar, all points going straight, (n,) bool.

    before, after  points from that axis at two times [m], (P, 3)

    Seen along the axis, a segment spans an angle a < pi. When its ends go on by b and c, it spans a + c - b, unless
    it went across: then that is wrong by a whole turn.
    """
    old, new = (points[:, 0] + 1j * points[:, 1] for points in (before, after))
    gone = np.angle(new * old.conj())
    begins, ends = segments.T
    spans = [np.angle(points[ends] * points[begins].conj()) for points in (old, new)]
    return np.abs(spans[0] + gone[ends] - gone[begins] - spans[1]) > np.pi
