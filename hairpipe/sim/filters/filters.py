"""The filters of a scene, as integrators call them: strain limit and body, each absent where the scene has none."""

from dataclasses import dataclass

import numpy as np

from hairpipe.levelset.field import Field
from hairpipe.levelset.interpolation import Interpolation
from hairpipe.sim.filters.chain import limit_all, limit_and_collide
from hairpipe.sim.models.chain import Chain
from hairpipe.sim.models.network import Network
from hairpipe.sim.scene import BodyContact, StrainLimit


@dataclass(frozen=True, eq=False)
class Filters:
    """What corrects positions and velocities in a step between two frames.

    fields  of the body at the previous and at this frame; None: nothing to collide with
    frame   time between them [s]
    """

    model: Network | Chain
    strain: StrainLimit | None
    contact: BodyContact
    fields: tuple[Field, Field] | None
    frame: float

    def limit_velocity(self, x: np.ndarray, v: np.ndarray, dt: float) -> None:
        """Change v so that x + dt v keeps the strain limit, in place; x, v (rows, 3, W)."""
        if self.strain is not None:
            target = x + dt * v
            limited = target.copy()
            limit_all(self.model, limited, self.strain.tolerance)
            v += (limited - target) / dt

    def collide(self, x: np.ndarray, v: np.ndarray, before: np.ndarray, time: float, dt: float) -> None:
        """Move hair out of the body at the end of a step that began at a time [s], in place.

        x, v, before  positions and velocities now, positions at the start of the step, (rows, 3, W)
        """
        if self.fields is not None:
            self._limit_and_collide(self.fields, x, v, before, time, dt, np.inf)

    def finish(self, x: np.ndarray, v: np.ndarray, before: np.ndarray, time: float, dt: float) -> None:
        """Limit strain and collide at the end of a step, in place; arguments as for `collide`."""
        tolerance = np.inf if self.strain is None else self.strain.tolerance
        if self.fields is not None:
            self._limit_and_collide(self.fields, x, v, before, time, dt, tolerance)
        elif self.strain is not None:
            limit_all(self.model, x, tolerance)

    def _limit_and_collide(
        self,
        fields: tuple[Field, Field],
        x: np.ndarray,
        v: np.ndarray,
        before: np.ndarray,
        time: float,
        dt: float,
        tolerance: float,
    ) -> None:
        scheme, contact = int(Interpolation[self.contact.interpolation]), self.contact
        body = (*fields, self.frame, (time, time + dt), scheme, contact.friction, contact.thickness)
        limit_and_collide(self.model, x, v, before, tolerance, *body)
