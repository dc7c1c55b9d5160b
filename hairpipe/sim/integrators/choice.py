"""Which integrator a scene asks for."""

import numpy as np

from hairpipe.sim.integrators.backward_euler import BackwardEuler
from hairpipe.sim.integrators.bdf2 import Bdf2
from hairpipe.sim.integrators.interface import Integrator
from hairpipe.sim.integrators.nine_steps import FullStep, Trapezoid
from hairpipe.sim.integrators.tr_bdf2 import TrBdf2
from hairpipe.sim.settings import Scene
from hairpipe.sim.solve.spring_form import SpringForm
from hairpipe.sim.solve.stage import Rule

_SCHEMES = {"tr_bdf2": TrBdf2, "bdf2": Bdf2, "backward_euler": BackwardEuler}
_NINE_STEPS = {"trapezoid": Trapezoid, "full_step": FullStep}


def integrator_of(scene: Scene) -> Integrator:
    """Build the integrator of a scene."""
    scheme = scene.scheme
    rule = Rule(
        int(SpringForm[scheme.spring]),
        scheme.overdamping,
        scheme.guard,
        scheme.iterations,
        gravity_of(scene),
        scene.air.drag if scene.wind is None else 0.0,  # the wind's own drag takes its place
    )
    kinds = _NINE_STEPS if scheme.value == "nine_steps" else _SCHEMES
    return kinds[scheme.velocity if scheme.value == "nine_steps" else scheme.value](rule)


def gravity_of(scene: Scene) -> np.ndarray:
    """Return the acceleration of free fall [m/s^2], (3,)."""
    return np.array([0.0, -scene.gravity, 0.0])
