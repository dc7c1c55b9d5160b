"""The protocol of a collider, a body that moves between two frames: distance queries and continuous collision."""

from typing import NamedTuple, Protocol

import numpy as np


class SdfSample(NamedTuple):
    """Samples of the signed distance to a body at points; of several bodies, the nearest.

    distance  signed, negative inside [m], (P,) float64
    normal    unit, outward, (P, 3) float64; 0 where no way out is shorter than others
    velocity  of the body there [m/s], (P, 3) float64
    """

    distance: np.ndarray
    normal: np.ndarray
    velocity: np.ndarray

    @classmethod
    def blank(cls, count: int, reach: float | np.ndarray = np.inf) -> "SdfSample":
        """Return samples at so many points without any body; bodies beyond reach [m], (P,), will not be written."""
        return cls(np.full(count, reach), np.zeros((count, 3)), np.zeros((count, 3)))


class FirstHit(NamedTuple):
    """When points that move first hit a body; of several bodies, the first hit.

    fraction  of the way from the old position to the new, 0 to 1; inf where there is no hit, (P,) float64
    """

    fraction: np.ndarray

    @classmethod
    def blank(cls, count: int) -> "FirstHit":
        """Return so many points without a hit."""
        return cls(np.full(count, np.inf))


class Walk(NamedTuple):
    """Points that move straight from one place to another, as kernels take them.

    before, after  where from, and where to [m], (P, 3) float64
    thickness      distance from a body at which each has hit it, less than the body's band [m], (P,) float64
    begin, finish  distances from bodies that both ends are known to have at least, -inf: nothing is [m], (P,) float64
    """

    before: np.ndarray
    after: np.ndarray
    thickness: np.ndarray
    begin: np.ndarray
    finish: np.ndarray


class Collider(Protocol):
    """A body between two frames. Times are counted from the first of them [s].

    Both queries write in place, only where this body is nearer, or hit sooner, than what is written already: the union
    of bodies is queried one body after another. Results do not depend on the number of threads.
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
        reach    where it is not below that, only the distance is written [m], (P,); None: everywhere all

        Nothing is written for a point beyond the narrow band of the body.
        """
        ...

    def sweep(self, walk: Walk, start: float, end: float, out: FirstHit) -> None:
        """Write the fraction of the way at which the distance first is below the thickness, if below out.fraction.

        start, end  times at both ends of the walk

        At that fraction the point is still outside. A point that begins nearer than its thickness is compared with the
        distance it begins with, so that contact at rest is detected, too; one that begins inside has no hit. A point
        that crosses a thin part and leaves it on its other side is detected.
        """
        ...
