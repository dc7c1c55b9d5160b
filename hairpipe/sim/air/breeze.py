"""The wind of a shot as the solver sees it: a force on every point of the hair, linear in its velocity."""

import numpy as np

from hairpipe.sim.air.cylinder import law_of
from hairpipe.sim.air.drag import add_drag
from hairpipe.sim.air.gusts import add_gusts, modes_of
from hairpipe.sim.air.shield import Shield, shield_of, weaken
from hairpipe.sim.air.wind import Wind


class Breeze:
    """Wind over hair of one diameter."""

    def __init__(self, wind: Wind, diameter: float) -> None:
        """Draw the gusts, and find the drag of a hair of this diameter [m]."""
        self.wind = wind
        self.diameter = diameter
        self.law = law_of(wind, diameter)
        self.modes = modes_of(wind.gusts) if wind.gusts else None
        self._shield: Shield | None = None

    def begin(self, points: np.ndarray, offsets: np.ndarray) -> None:
        """Count the hair that shields, for all solves of a step; without it, every one counts anew."""
        self._shield = shield_of(points, offsets, self.wind, self.law, self.diameter)

    def air(self, points: np.ndarray, offsets: np.ndarray, seconds: float) -> np.ndarray:
        """Return the velocity of the air at points of hair, (P, 3) [m], at an absolute time of the shot [m/s], (P, 3).

        The mean wind and its gusts, as far as the hair in front of it lets them through.
        """
        return self._air(points, self._counted(points, offsets), seconds)

    def forces(
        self,
        points: np.ndarray,
        velocities: np.ndarray,
        offsets: np.ndarray,
        seconds: float,
        active: np.ndarray,
        push: np.ndarray,
        damping: np.ndarray,
    ) -> None:
        """Add the force push - damping v of the air on active points, in place; arrays as for `add_drag`.

        seconds  absolute time of the shot, so that a run that is resumed meets the same gusts
        """
        air, some = np.empty_like(points), slice(None) if active.all() else active
        air[some] = self._air(points[some], self._counted(points, offsets), seconds)
        add_drag(points, velocities, air, offsets, self.law, active, push, damping)

    def _counted(self, points: np.ndarray, offsets: np.ndarray) -> Shield | None:
        """Return the hair that shields."""
        return self._shield or shield_of(points, offsets, self.wind, self.law, self.diameter)

    def _air(self, points: np.ndarray, shield: Shield | None, seconds: float) -> np.ndarray:
        """Return the velocity of the air at some points behind a shield; otherwise as `air`."""
        velocity = np.array(self.wind.velocity)
        air = np.tile(velocity, (len(points), 1))
        if self.modes is not None:
            add_gusts(self.modes, velocity, points, seconds, air)
        if shield is not None:
            weaken(shield, points, air)
        return air
