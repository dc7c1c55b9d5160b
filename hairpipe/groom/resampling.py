"""Curves cut into segments of equal length: every new point lies on the curve, one chord from the last.

The number of segments of a strand is given, or by its length, or by its shape.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.vec3 import Vector, dot, length, minus, mix, plus, put, row, scaled, unit
from hairpipe.groom.settings import SHORTEST

HALVINGS = 60  # of the interval that holds the chord: down to rounding
PIECES = 8  # of a smooth span, as a polyline
SLACK = 1e-9  # by which the arc may come out short of the chords of a straight strand


@njit(cache=True)
def cut_by_sphere(a: Vector, b: Vector, centre: Vector, radius: float) -> Vector:
    """Return the point between a, inside a sphere, and b, outside it, at which it is crossed."""
    ab, ca = minus(b, a), minus(a, centre)
    square = dot(ab, ab)
    half = dot(ab, ca)
    rest = dot(ca, ca) - radius * radius
    root = np.sqrt(max(half * half - square * rest, 0.0))
    t = (root - half) / square if half <= 0.0 else -rest / (root + half)  # The form of the root without cancellation.
    return mix(a, b, min(max(t, 0.0), 1.0))


@njit(cache=True)
def stride(curve: np.ndarray, chord: float, points: np.ndarray) -> int:
    """Write points (n, 3) along a polyline (k, 3) by equal chords [m], from its first; return how many it reaches."""
    here = a = row(curve, 0)
    put(points, 0, here)
    k = 1
    for i in range(1, len(points)):
        while k < len(curve) and length(minus(row(curve, k), here)) < chord:  # Forward only, to the first exit.
            a = row(curve, k)
            k = k + 1
        if k == len(curve):
            return i
        here = a = cut_by_sphere(a, row(curve, k), here, chord)
        put(points, i, here)
    return len(points)


@njit(cache=True)
def stride_on(curve: np.ndarray, chord: float, points: np.ndarray) -> None:
    """Do the same, and extrapolate beyond the end of the polyline until all points are written."""
    reached = stride(curve, chord, points)
    last = len(curve) - 1
    ahead = unit(minus(row(curve, last), row(curve, last - 1)), (0.0, -1.0, 0.0))
    for i in range(reached, len(points)):
        put(points, i, plus(row(points, i - 1), scaled(chord, ahead)))


@njit(cache=True)
def arc_length(curve: np.ndarray) -> float:
    """Return the length of a polyline [m]."""
    total = 0.0
    for k in range(1, len(curve)):
        total += length(minus(row(curve, k), row(curve, k - 1)))
    return total


@njit(cache=True)
def divide(curve: np.ndarray, points: np.ndarray) -> None:
    """Write points (n + 1, 3) that divide a polyline into n equal chords, from its first point to its last.

    The chord is found by bisection, between the n-th parts of the straight line and of the arc. On a curl with few
    segments per turn no chord may end exactly at the last point, since a longer one skips a bend: then the chords end
    before it, on the curve, and add up to much less than the arc.
    """
    n = len(points) - 1
    low = length(minus(row(curve, len(curve) - 1), row(curve, 0))) / n * (1.0 - SLACK)
    high = arc_length(curve) / n * (1.0 + SLACK)
    for _ in range(HALVINGS):  # A fixed number, down to rounding: no tolerance decides.
        chord = 0.5 * (low + high)
        if stride(curve, chord, points) > n:
            low = chord
        else:
            high = chord
    stride_on(curve, low, points)


@njit(cache=True)
def smooth(points: np.ndarray) -> np.ndarray:
    """Return the uniform Catmull-Rom curve through points (k, 3), its ends pinned, as a polyline."""
    spans = len(points) - 1
    curve = np.empty((spans * PIECES + 1, 3))
    for i in range(spans):
        b = row(points, i)
        c = row(points, i + 1)
        a = row(points, i - 1) if i > 0 else minus(scaled(2.0, b), c)
        d = row(points, i + 2) if i + 2 <= spans else minus(scaled(2.0, c), b)
        for j in range(PIECES):
            put(curve, i * PIECES + j, catmull_rom(a, b, c, d, j / PIECES))
    put(curve, spans * PIECES, row(points, spans))
    return curve


@njit(cache=True)
def catmull_rom(a: Vector, b: Vector, c: Vector, d: Vector, t: float) -> Vector:
    """Return the uniform Catmull-Rom curve at t, from b at 0 to c at 1."""
    wa = -0.5 * t * (1.0 - t) ** 2
    wd = -0.5 * t * t * (1.0 - t)
    wb = 1.0 - 2.5 * t * t + 1.5 * t**3
    wc = 1.0 - wa - wb - wd
    return plus(plus(scaled(wa, a), scaled(wb, b)), plus(scaled(wc, c), scaled(wd, d)))


def spline_knots(hull: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return the knots of uniform cubic B-splines, (p, 3), one per point of their control hull; pure.

    (p_k-1 + 4 p_k + p_k+1) / 6; the ends are pinned by mirrored points, as in USD: there the knot is the point itself.

    hull     control points of the curves [m], (p, 3); offsets  strand s owns hull[offsets[s]:offsets[s+1]], (S+1,)
    """
    knots = (np.roll(hull, 1, axis=0) + 4.0 * hull + np.roll(hull, -1, axis=0)) / 6.0
    for ends in (offsets[:-1], offsets[1:] - 1):
        knots[ends] = hull[ends]
    return knots


@njit(cache=True, parallel=True)
def equal_segments(points: np.ndarray, offsets: np.ndarray, new_offsets: np.ndarray) -> np.ndarray:
    """Return strands divided into segments of equal length along smooth curves through their points.

    points       points of all strands [m], (p, 3) float64; every strand has a positive length
    offsets      strand s owns points offsets[s]:offsets[s+1], (S+1,)
    new_offsets  the same for the points returned, (S+1,)
    """
    cut = np.empty((new_offsets[-1], 3))
    for s in prange(len(offsets) - 1):
        curve = smooth(points[offsets[s] : offsets[s + 1]])
        divide(curve, cut[new_offsets[s] : new_offsets[s + 1]])
    return cut


FINE, A_TURN = 0.005, 16  # segment of straight hair [m], and segments in a turn of a curl
FEWEST, MOST, LATTICE = 25, 200, 5
"""Segments of a strand; in whole runs of the lattice, which turns one way for five (`strands/lattice.py`)."""
ROUNDING = 1e-9


@dataclass(frozen=True)
class Cut:
    """Division of strands into segments; raises BadInput if both a number and a length are given.

    segments        number of segments of every strand; None: not given
    segment_length  maximum length of a segment [m]; None: not given
    shortest        minimum length of a segment [m]
    """

    segments: int | None = None
    segment_length: float | None = None
    shortest: float = SHORTEST

    def __post_init__(self) -> None:
        if self.segments is not None and self.segment_length is not None:
            both = f"segments = {self.segments} and segment_length = {self.segment_length:g} are both given"
            raise BadInput(both, right="one of the two")

    def wanted(self, lengths: np.ndarray | float, unless_said: np.ndarray | int) -> np.ndarray:
        """Return how many segments strands of given lengths [m] are asked to have, (S,) int64."""
        if self.segment_length is not None:
            asked = np.maximum(np.ceil(np.asarray(lengths) / self.segment_length - ROUNDING), 1.0)
            return asked.astype(np.int64)
        asked = unless_said if self.segments is None else self.segments
        return np.broadcast_to(asked, np.shape(lengths)).astype(np.int64)

    def bearable(self, lengths: np.ndarray) -> np.ndarray:
        """Return how many segments strands of given lengths [m] bear, (S,) int64; 0 where they are shorter than one."""
        return np.floor(lengths / self.shortest + ROUNDING).astype(np.int64)


def fitting(lengths: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return the number of segments that hair needs, (S,) int64; pure.

    One for every FINE of the length, A_TURN for every turn of a curl, from FEWEST to MOST, rounded up to whole periods
    of the lattice. Against rod theory the tip of a cantilever of 5 to 25 cm is then within 0.7 % of its length, the
    stiffness of helices of 4 to 15 mm within 3 %, where half as many leave 12 to 21 %.

    lengths  lengths of the strands [m], (S,)
    turns    arc length of a turn of their curls [m], (S,); inf for straight strands
    """
    needed = lengths * np.maximum(1.0 / FINE, A_TURN / turns)
    runs = np.ceil(np.clip(needed, FEWEST, MOST) / LATTICE - ROUNDING)
    return (LATTICE * runs).astype(np.int64)
