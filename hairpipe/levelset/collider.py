"""A body that moves between two frames, as hair meets it: how near it is, and whether something ran into it."""

from typing import NamedTuple, Protocol

import numpy as np


class Probe(NamedTuple):
    """What a body is like at points; of several bodies, the nearest.

    distance  signed, negative inside [m], (P,) float64
    normal    unit, outward, (P, 3) float64; 0 where no way out is shorter than others
    velocity  of the body there [m/s], (P, 3) float64
    """

    distance: np.ndarray
    normal: np.ndarray
    velocity: np.ndarray

    @classmethod
    def blank(cls, count: int, reach: float = np.inf) -> "Probe":
        """Make a probe of so many points that has met nothing yet; bodies farther than reach [m] will not show."""
        return cls(np.full(count, reach), np.zeros((count, 3)), np.zeros((count, 3)))


class Sweep(NamedTuple):
    """When points that move run into a body; of several bodies, into the first.

    fraction  of the way from where they were to where they are, 0 to 1; inf: they do not, (P,) float64
    """

    fraction: np.ndarray

    @classmethod
    def blank(cls, count: int) -> "Sweep":
        """Make a sweep of so many points that have run into nothing yet."""
        return cls(np.full(count, np.inf))


class Walk(NamedTuple):
    """Points that move straight from one place to another, as kernels take them.

    before, after  where from, and where to [m], (P, 3) float64
    thickness      distance from a body at which each has hit it [m], (P,) float64
    """

    before: np.ndarray
    after: np.ndarray
    thickness: np.ndarray


class MovingSurface(Protocol):
    """A body between two frames. Times are counted from the first of them [s].

    Probe and sweep write in place, only where this body is nearer, or met sooner, than what is written already: a union
    of bodies is one body after the other. Results do not depend on the number of threads.
    """

    @property
    def speed(self) -> float:
        """No point of the body is faster [m/s]."""
        ...

    def probe(self, points: np.ndarray, seconds: float, out: Probe) -> None:
        """Write distance, normal and velocity where the distance is smaller than out.distance.

        points   [m], (P, 3) float64

        A point beyond the body's band is out of reach: there nothing is written.
        """
        ...

    def sweep(
        self, before: np.ndarray, after: np.ndarray, start: float, end: float, thickness: np.ndarray, out: Sweep
    ) -> None:
        """Write the fraction of the way at which the distance first is below the thickness, if below out.fraction.

        before, after  positions at the times start and end [m], (P, 3) float64; between them they move straight
        thickness      less than the body's band [m], (P,) float64

        At that fraction the point is still outside. A point that begins nearer than its thickness is judged by the
        distance it begins with, so that what rests on the body is caught like everything else; one that begins inside
        is never met. What crosses a thin part and comes out on its other side is caught.
        """
        ...
