"""What points saw of the bodies around them, so that only those look again that may see something else.

Within a step points are looked at many times: where they begin, where a stage is foreseen to end, where it ends, where
the step does. At one time nobody sees anything new who stays in place, nor does a point that is free and so far from
all bodies that it cannot have come near: distances change by at most STEEPEST times the way. Of those the distance may
be off by that; nothing reads it where it is so great.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit, prange

from hairpipe.levelset.collider import MovingSurface, Probe

STEEPEST = 2.0
"""Change of a distance over the way: of samples of a distance, as they are interpolated, at most the root of 3."""


@dataclass(eq=False)
class Sight:
    """What so many points saw of bodies that are one.

    reach   beyond which bodies do not show [m]; far  distance beyond which it does not matter what is seen [m]
    probe   what was seen last: changed in place
    """

    surfaces: Sequence[MovingSurface]
    count: int
    reach: float
    far: float
    probe: Probe = field(init=False)
    _places: np.ndarray = field(init=False)
    _time: float = field(default=np.nan, init=False)

    def __post_init__(self) -> None:
        self.probe = Probe.blank(self.count, self.reach)
        self._places = np.full((self.count, 3), np.nan)

    def renew(self, points: np.ndarray, time: float, who: np.ndarray, bound: np.ndarray) -> None:
        """Look from points [m], (P, 3), at a time since the previous frame [s].

        who    points that do, (P,) bool; the others keep what they saw last, wherever and whenever that was
        bound  to a body, whatever its distance: these look unless they did from the same place, (P,) bool
        """
        if time != self._time:
            self._places[:] = np.nan
            self._time = time
        again = np.flatnonzero(_unsure(points, self._places, self.probe.distance, who, bound, self.far))
        if len(again) == self.count:
            self._places[:] = points
            self._look(points, self.probe)
        elif len(again):
            places, some = np.empty((len(again), 3)), Probe.blank(len(again), self.reach)
            _take(points, again, places, self._places)
            self._look(places, some)
            _put(some, again, *self.probe)

    def _look(self, places: np.ndarray, out: Probe) -> None:
        out.distance[:], out.normal[:], out.velocity[:] = self.reach, 0.0, 0.0
        for surface in self.surfaces:
            surface.probe(places, self._time, out)


@njit(cache=True, parallel=True)
def _unsure(points, places, distance, who, bound, far):
    """Mark the points, (P,) bool, of those who look, that may see another body than they did from places, (P, 3)."""
    unsure = np.empty(len(points), np.bool_)
    for i in prange(len(points)):
        x, y, z = points[i, 0] - places[i, 0], points[i, 1] - places[i, 1], points[i, 2] - places[i, 2]
        way = np.sqrt(x * x + y * y + z * z)
        known = way == 0.0 or (not bound[i] and distance[i] - STEEPEST * way > far)
        unsure[i] = who[i] and not known
    return unsure


@njit(cache=True, parallel=True)
def _take(points, which, out, places):
    """Set out, (n, 3), and the places of points to where those which, (n,), are, in place."""
    for k in prange(len(which)):
        for c in range(3):
            out[k, c] = places[which[k], c] = points[which[k], c]


@njit(cache=True, parallel=True)
def _put(some, which, distance, normal, velocity):
    """Write what some points, (n,), saw to what all have seen, a Probe, unpacked; in place."""
    for k in prange(len(which)):
        i = which[k]
        distance[i] = some.distance[k]
        for c in range(3):
            normal[i, c], velocity[i, c] = some.normal[k, c], some.velocity[k, c]
