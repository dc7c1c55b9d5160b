"""PyElastica: Cosserat rods in explicit steps (Gazzola et al. 2018); GazzolaLab/PyElastica, MIT."""

from importlib import import_module
from importlib.metadata import version
from typing import Any

import numpy as np

from hairpipe.graphs.experiments.peers.hanging import FRAME, Hanging, Peer, Strands

INERTIA = 1000.0
"""Factor of the rotary inertia, whose quick modes bound an explicit step: the radius of gyration is then 0.6 mm."""
TRUTH_SEGMENTS, TRUTH_STEPS, TRUTH_SOFTENING = 200, 5120, 25.0


def peers() -> list[Peer]:
    """List the settings that are compared: about twice as many steps are needed as are stable."""
    words = f"position Verlet, EA and GA / 100, rotary inertia x {INERTIA:g}"
    return [
        Peer(
            f"PyElastica {version('pyelastica')}",
            words,
            50,
            1700,
            10,
            lambda scene, strands: Elastica(scene, strands, 50, 1700, scene.material.softening),
        )
    ]


def converged(scene: Hanging) -> Strands:
    """Lay a strand that is resolved beyond all others."""
    return Elastica(scene, 1, TRUTH_SEGMENTS, TRUTH_STEPS, TRUTH_SOFTENING)


class Elastica:
    """Strands of PyElastica; see `Strands`."""

    def __init__(self, scene: Hanging, strands: int, segments: int, steps: int, softening: float) -> None:
        self._library = elastica = import_module("elastica")
        self._steps = steps
        self._time = 0.0
        parts = (elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping)
        self._scene = type("Scene", parts, {})()
        self._rods = [self._rod(scene, segments, softening) for _ in range(strands)]
        self._scene.finalize()
        self._stepper = elastica.PositionVerlet()

    def _rod(self, scene: Hanging, segments: int, softening: float) -> Any:
        elastica, fibre = self._library, scene.material
        size = scene.centred(segments)
        start = -size / 2 * scene.direction
        normal = np.array([0.0, 0.0, 1.0])
        shear = fibre.young / (2 * (1 + fibre.poisson))
        rod = elastica.CosseratRod.straight_rod(
            segments,
            start,
            scene.direction,
            normal,
            segments * size,
            fibre.diameter / 2,
            fibre.density,
            youngs_modulus=fibre.young,
            shear_modulus=shear,
        )
        rod.shear_matrix /= softening
        rod.mass_second_moment_of_inertia *= INERTIA
        rod.inv_mass_second_moment_of_inertia /= INERTIA
        self._scene.append(rod)
        held = {"constrained_position_idx": (0, 1), "constrained_director_idx": (0,)}
        self._scene.constrain(rod).using(elastica.FixedConstraint, **held)
        pull = np.array([0.0, -scene.gravity, 0.0])
        self._scene.add_forcing_to(rod).using(elastica.GravityForces, acc_gravity=pull)
        if scene.drag > 0.0:
            damper = elastica.AnalyticalLinearDamper
            rate = {"uniform_damping_constant": scene.drag, "time_step": FRAME / self._steps}
            self._scene.dampen(rod).using(damper, **rate)
        return rod

    def advance(self) -> None:
        """Advance by a frame."""
        for _ in range(self._steps):
            self._time = self._stepper.step(self._scene, self._time, FRAME / self._steps)

    def points(self) -> np.ndarray:
        """Nodes of the first strand [m], (n, 3)."""
        return self._rods[0].position_collection.T.copy()
