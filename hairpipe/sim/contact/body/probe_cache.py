"""A cache of distances to bodies: only points whose answer may have changed are queried again.

Within a step points are queried many times: where they begin, where a stage is predicted to end, where it ends, where
the step does. Within one time, a point that has not moved need not be
queried again, nor a free point so far from all bodies that it cannot have come near: distances change by at most
STEEPEST times the way. Of such points the cached distance may be off by that; nothing reads it where it is so great.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit, prange

from hairpipe.levelset.collider import MovingSurface, Probe

STEEPEST = 2.0
"""Change of a distance over the way: of samples of a distance, as they are interpolated, at most the root of 3."""


@dataclass(eq=False)
class ProbeCache:
    """The last answer for every point, of bodies taken as one.

    reach   beyond which bodies are not found [m]; far  distance beyond which the answer does not matter [m]
    probe   last answers: changed in place
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

    def renew(self, points: np.ndarray, time: float, active: np.ndarray, bound: np.ndarray) -> None:
        """Query the bodies at points [m], (P, 3), at a time since the previous frame [s].

        active  points that are queried, (P,) bool; the others keep their last answers, from wherever and whenever
        bound   to a body, whatever its distance: queried unless they have not moved, (P,) bool
        """
        if time != self._time:
            self._places[:] = np.nan
            self._time = time
        again = np.flatnonzero(_unsure(points, self._places, self.probe.distance, active, bound, self.far))
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
def _unsure(points, places, distance, active, bound, far):
    """Mark the active points, (P,) bool, whose answers may differ from those at places, (P, 3)."""
    unsure = np.empty(len(points), np.bool_)
    for i in prange(len(points)):
        x, y, z = points[i, 0] - places[i, 0], points[i, 1] - places[i, 1], points[i, 2] - places[i, 2]
        way = np.sqrt(x * x + y * y + z * z)
        known = way == 0.0 or (not bound[i] and distance[i] - STEEPEST * way > far)
        unsure[i] = active[i] and not known
    return unsure


@njit(cache=True, parallel=True)
def _take(points, which, out, places):
    """Set out, (n, 3), and the places of points to where those which, (n,), are, in place."""
    for k in prange(len(which)):
        for c in range(3):
            out[k, c] = places[which[k], c] = points[which[k], c]


@njit(cache=True, parallel=True)
def _put(some, which, distance, normal, velocity):
    """Write the answers for some points, (n,), to those for all, a Probe, unpacked; in place."""
    for k in prange(len(which)):
        i = which[k]
        distance[i] = some.distance[k]
        for c in range(3):
            normal[i, c], velocity[i, c] = some.normal[k, c], some.velocity[k, c]
