"""Air as an interaction: a force on every point of the hair, linear in its velocity."""

import numpy as np

from hairpipe.sim.air.cylinder import law_of
from hairpipe.sim.air.drag import add_drag
from hairpipe.sim.air.gusts import add_gusts, modes_of
from hairpipe.sim.air.shield import Shield, shield_of, weaken
from hairpipe.sim.air.wind import Wind
from hairpipe.sim.interactions import Interaction, Prediction, Start


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
