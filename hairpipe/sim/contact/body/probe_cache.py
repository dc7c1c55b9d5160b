"""A cache of distances to bodies: only points whose answer may have changed are queried again.

Within a step points are queried many times: at the start, at the predicted and the computed end of each stage, and at
the end of the step. An unmoved point is not queried again at the same time, nor is a free point that cannot have come
near: distances change by at most STEEPEST times the path of the point and of the bodies. The cached distance of such a
point may have an error of that size; it is read only where the error is harmless.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.kernels.vec3 import length, minus, row
from hairpipe.levelset.collider import Collider, SdfSample

STEEPEST = 2.0
"""Change of a distance over the way: of samples of a distance, as they are interpolated, at most the root of 3."""


@dataclass(eq=False)
class ProbeCache:
    """The last result for every point, of bodies as one.

    reach      distance beyond which bound points get the distance only [m]
    far        distance beyond which free points get the distance only, which is not used [m]
    probe      last results, changed in place
    clearance  lower bound of the distance at the last query [m], (P,); exact up to `far`
    """

    surfaces: Sequence[Collider]
    count: int
    reach: float
    far: float
    probe: SdfSample = field(init=False)
    clearance: np.ndarray = field(init=False)
    _band: float = field(init=False)
    _speed: float = field(init=False)
    _places: np.ndarray = field(init=False)
    _times: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self._band = min((surface.band for surface in self.surfaces), default=np.inf)
        self._speed = max((surface.speed for surface in self.surfaces), default=0.0)
        self.probe = SdfSample.blank(self.count, self._band)
        self.clearance = np.full(self.count, np.nan)
        self._places = np.full((self.count, 3), np.nan)
        self._times = np.full(self.count, np.nan)

    def renew(self, points: np.ndarray, time: float, active: np.ndarray, bound: np.ndarray) -> None:
        """Query the bodies at points [m], (P, 3), at a time since the previous frame [s].

        active  points to query, (P,) bool; the others keep their last results, of any position and time
        bound   points bound to a body at any distance: queried if they have moved, (P,) bool
        """
        seen = _Seen(self._places, self._times, self.probe.distance)
        unsure = np.empty(self.count, np.bool_)
        _find_unsure(points, time, seen, active, bound, (self.far, self._speed), self.clearance, unsure)
        again = np.flatnonzero(unsure)
        if len(again):
            places = np.empty((len(again), 3))
            some = SdfSample.blank(len(again), self._band)
            _take(points, again, places, self._places)
            reach = np.where(bound[again], self.reach, self.far)
            for surface in self.surfaces:
                surface.probe(places, time, some, reach)
            self._times[again] = time
            self.clearance[again] = some.distance
            _put(some, again, *self.probe)


class _Seen(NamedTuple):
    """Places, times and results of the last probes."""

    places: np.ndarray
    times: np.ndarray
    distance: np.ndarray


@njit(cache=True, parallel=True)
def _find_unsure(points, time, seen, active, bound, law, clearance, unsure):
    """Mark active points whose answers may differ from those seen, (P,) bool, and bound the others, in place."""
    far, speed = law
    for i in prange(len(points)):
        unsure[i] = False
        if active[i]:
            way = length(minus(row(points, i), row(seen.places, i))) + speed * abs(time - seen.times[i])
            least = seen.distance[i] - STEEPEST * way
            # The same place and time, or a free point that cannot have come near: nobody reads its exact distance.
            known = (way == 0.0 and time == seen.times[i]) or (not bound[i] and least > far)
            unsure[i] = not known
            if known:
                clearance[i] = least  # A bound from below, as the distance itself is no longer known.


@njit(cache=True, parallel=True)
def _take(points, which, out, places):
    """Set out, (n, 3), and the places of points to where those which, (n,), are, in place."""
    for k in prange(len(which)):
        for c in range(3):
            out[k, c] = places[which[k], c] = points[which[k], c]


@njit(cache=True, parallel=True)
def _put(some, which, distance, normal, velocity):
    """Write the answers for some points, (n,), to those for all, a SdfSample, unpacked; in place."""
    for k in prange(len(which)):
        i = which[k]
        distance[i] = some.distance[k]
        for c in range(3):
            normal[i, c], velocity[i, c] = some.normal[k, c], some.velocity[k, c]
