"""Air as an interaction with strands, and with particles, each of which represents a number of parallel fibres."""

from dataclasses import replace
from math import hypot
from typing import NamedTuple
from warnings import warn

import numpy as np
from numba import njit, prange

from hairpipe.laws.drag import Law, add_drag_of_segment, law_of
from hairpipe.laws.gusts import add_gusts, modes_of
from hairpipe.laws.settings import Wind
from hairpipe.solve.interactions import Interaction, Prediction, Start
from hairpipe.volume.shielding import Shield, shield_of, weaken


@njit(cache=True, parallel=True, error_model="numpy")
def add_drag(
    at: Prediction,
    air: np.ndarray,
    offsets: np.ndarray,
    law: Law,
    sizes: np.ndarray,
    push: np.ndarray,
    damping: np.ndarray,
) -> None:
    """Add the force push - damping v of the air on active points, in place; values of the others are not read."""
    for strand in prange(len(offsets) - 1):
        end = offsets[strand + 1] if at.active[offsets[strand]] else offsets[strand]  # A strand is active as a whole.
        for k in range(offsets[strand], end - 1):  # One thread per strand: segments add to common points in order.
            add_drag_of_segment(at.points, at.lagged_velocity, air, k, law, sizes[k], push, damping)


STORM = 115.0
"""Speed of the strongest gust that was measured near the ground, in 1996, rounded up [m/s]."""


def warn_of_storm(wind: Wind | None) -> None:
    """Warn of a mean velocity above that of any storm."""
    speed = 0.0 if wind is None else hypot(*wind.velocity)
    if speed > STORM:
        message = f"wind.velocity has {speed:,.0f} m/s, above {STORM:.0f} m/s, the strongest gust ever measured"
        warn(f"{message} (velocities are in m/s)", stacklevel=3)


class Breeze(Interaction):
    """Wind over hair; offsets of its strands, (S+1,) int32, and widths of segments, see `shield_of`."""

    def __init__(
        self,
        wind: Wind,
        diameter: float,
        offsets: np.ndarray,
        widths: np.ndarray | None = None,
        diameters: np.ndarray | None = None,
    ) -> None:
        """Draw the gusts, and find the drag of hair of a mean diameter, and of diameters at points, (P,) [m]."""
        self.wind = wind
        self.diameter = diameter
        self.offsets = offsets
        self.widths = widths
        self.law = law_of(wind, diameter)
        self.varied = None if diameters is None else segment_means(diameters / np.float64(diameter))
        self.modes = modes_of(wind.gusts) if wind.gusts else None
        self._shield: Shield | None = None

    def begin(self, start: Start) -> None:
        """Count the shielding hair once for all solves of a step."""
        self._shield = self._counted(start.points)

    def air(self, points: np.ndarray, seconds: float) -> np.ndarray:
        """Return the velocity of the air at points of hair, (P, 3) [m], at an absolute time of the shot [m/s], (P, 3).

        It is the mean wind and its gusts, reduced by the hair upstream.
        """
        return self._air(points, self._shield or self._counted(points), seconds)

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the force push - damping v of the air, in place; gusts depend on the time of the shot."""
        air = np.empty_like(at.points)
        some = slice(None) if at.active.all() else at.active
        air[some] = self._air(at.points[some], self._shield or self._counted(at.points), at.seconds)
        sizes = np.ones(len(at.points)) if self.varied is None else self.varied
        add_drag(at, air, self.offsets, self.law, sizes, push, damping)

    def _counted(self, points: np.ndarray) -> Shield | None:
        """Return the shielding hair."""
        return shield_of(points, self.offsets, self.wind, self.law, self.diameter, self.widths, self.varied)

    def _air(self, points: np.ndarray, shield: Shield | None, seconds: float) -> np.ndarray:
        """Return the velocity of the air at some points behind a shield; otherwise as `air`."""
        velocity = np.array(self.wind.velocity)
        air = np.tile(velocity, (len(points), 1))
        if self.modes is not None:
            add_gusts(self.modes, velocity, points, seconds, air)
        if shield is not None:
            weaken(shield, points, air)
        return air


def segment_means(values: np.ndarray) -> np.ndarray:
    """Return the means of values of points and the next ones, (P,); those of the last points of strands are unused."""
    return 0.5 * (values + np.roll(values, -1))


class StillAir(Interaction):
    """Still air whose drag varies: its damping [kg/s] at every point, (P,), the rate times the mass that moves with it.

    The stages themselves contain the drag of one rate everywhere, which costs nothing.
    """

    def __init__(self, damping: np.ndarray) -> None:
        self.damping = damping

    def linearise(self, at: Prediction, push: np.ndarray, damping: np.ndarray) -> None:
        """Add the force -damping v, in place."""
        for diagonal in (0, 3, 5):
            damping[:, diagonal] += self.damping


class LooseFibres(NamedTuple):
    """Segments of fibre at particles.

    points, directions, velocities  [m], unit vectors, [m/s], (N, 3) each
    counts                          number of parallel fibres, (N,)
    segment                         length of each [m]
    diameter                        of a fibre [m]
    """

    points: np.ndarray
    directions: np.ndarray
    velocities: np.ndarray
    counts: np.ndarray
    segment: float
    diameter: float


def add_wind(wind: Wind, hair: LooseFibres, seconds: float, push: np.ndarray, drag: np.ndarray) -> None:
    """Add the force push - drag v of the air at a time of the shot [s], in place.

    push  [N], (N, 3)
    drag  symmetric xx xy xz yy yz zz [kg/s], (N, 6)

    All fibres of a particle shield other hair.
    """
    if wind.shielding is not None:
        hairs = wind.shielding.hairs * float(hair.counts.mean())
        wind = replace(wind, shielding=replace(wind.shielding, hairs=hairs))
    half = 0.5 * hair.segment * hair.directions
    count = len(hair.counts)
    ends = np.stack([hair.points - half, hair.points + half], axis=1).reshape(-1, 3)
    pace = np.repeat(hair.velocities, 2, axis=0)
    still = np.zeros(2 * count)
    at = Prediction(ends, pace, pace, still, still, np.ones(2 * count, bool), 0.0, 0.0, seconds)
    pushes, drags = np.zeros((2 * count, 3)), np.zeros((2 * count, 6))
    offsets = np.arange(0, 2 * count + 1, 2, dtype=np.int32)
    Breeze(wind, hair.diameter, offsets).linearise(at, pushes, drags)
    push += hair.counts[:, None] * pushes.reshape(count, 2, 3).sum(axis=1)
    drag += hair.counts[:, None] * drags.reshape(count, 2, 6).sum(axis=1)
