"""The protocol of a collider, a body that moves between two frames: distance queries and continuous collision."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

STEEPEST = 2.0
"""Change of a distance over the way: of samples of a distance, as they are interpolated, at most the root of 3."""


class SdfSample(NamedTuple):
    """Samples of the signed distance to a body at points; of several bodies, the nearest."""

    distance: np.ndarray  # signed, negative inside [m], (P,) float64
    normal: np.ndarray  # unit, outward, (P, 3) float64; 0 where the closest point is ambiguous
    velocity: np.ndarray  # of the body there [m/s], (P, 3) float64

    @classmethod
    def blank(cls, count: int, reach: float | np.ndarray = np.inf) -> "SdfSample":
        """Return samples at so many points without any body; bodies beyond reach [m], (P,), will not be written."""
        return cls(np.full(count, reach), np.zeros((count, 3)), np.zeros((count, 3)))


class FirstHit(NamedTuple):
    """First hits of moving points with a body; of several bodies, the earliest."""

    fraction: np.ndarray  # of the path from the old position to the new, 0 to 1; inf without a hit, (P,) float64

    @classmethod
    def blank(cls, count: int) -> "FirstHit":
        """Return so many points without a hit."""
        return cls(np.full(count, np.inf))


class Walk(NamedTuple):
    """Points that move along straight lines, as arguments of kernels."""

    before: np.ndarray  # start [m], (P, 3) float64
    after: np.ndarray  # end [m], (P, 3) float64
    thickness: np.ndarray  # distance from a body that counts as a hit, less than the body's band [m], (P,) float64
    begin: np.ndarray  # known lower bound of the distance of the start from bodies, -inf: unknown [m], (P,) float64
    finish: np.ndarray  # of the end


class Wander(NamedTuple):
    """Points that were at one place at an earlier time, and are at another now."""

    before: np.ndarray  # [m], (P, 3) float64
    then: float  # the earlier time [s]
    after: np.ndarray  # [m], (P, 3) float64
    now: float  # [s]
    which: np.ndarray  # the points to consider, (n,) int64


class Collider(Protocol):
    """A body between two frames. Times are counted from the first of them [s].

    Queries write in place, only where this body is nearer, or hit earlier, than the present value: the union of
    bodies is queried body by body. Results do not depend on the number of threads.
    """

    @property
    def speed(self) -> float:
        """Speed that no point of the body exceeds [m/s]."""
        ...

    @property
    def band(self) -> float:
        """Distance beyond which the body is not found [m]."""
        ...

    def probe(self, points: np.ndarray, seconds: float, out: SdfSample, reach: np.ndarray | None = None) -> None:
        """Write distance, normal and velocity where the distance is smaller than out.distance.

        points   [m], (P, 3) float64
        reach    distance from which on only the distance is written [m], (P,); None: all is written everywhere

        Nothing is written for a point beyond the narrow band of the body.
        """
        ...

    def approach(self, wander: Wander, out: np.ndarray) -> None:
        """Raise out to the ways of points relative to this body, where it is in reach of them now [m], (n,).

        The distance of a point has changed by no more than STEEPEST times that; inf where the body knows no bound.
        """
        ...

    def sweep(self, walk: Walk, start: float, end: float, out: FirstHit) -> None:
        """Write the fraction of the path at which the distance first is below the thickness, if below out.fraction.

        start, end  times at both ends of the path

        At that fraction the point is still outside. For a point that begins nearer than its thickness the initial
        distance is the threshold, so that contact at rest is detected, too; one that begins inside has no hit. A point
        that passes through a thin part is detected.
        """
        ...


def probe_union(bodies: Sequence[Collider], points: np.ndarray, reach: float | np.ndarray = np.inf) -> SdfSample:
    """Return samples of the union of bodies at time zero at points [m], (P, 3), blank beyond a reach [m]; pure."""
    sample = SdfSample.blank(len(points), reach)
    for body in bodies:
        body.probe(np.ascontiguousarray(points), 0.0, sample)
    return sample
