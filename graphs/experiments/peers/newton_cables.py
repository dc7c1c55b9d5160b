"""NVIDIA Newton: cables of rigid capsules by vertex block descent; newton-physics/newton, Apache-2.0."""

from importlib import import_module
from importlib.metadata import version

import numpy as np

from hairpipe.graphs.experiments.peers.hanging import FRAME, Hanging, Peer

MILLIGRAM = 1e6
"""Unit of mass, 1 / kg: in kilograms its single precision would have to hold masses of 4e-8."""


def peers() -> list[Peer]:
    """List the settings that are compared: steps of its examples, and steps in which ten iterations resolve bending."""
    return [_peer(50, 10, 100), _peer(25, 100, 40)]


def _peer(segments: int, steps: int, strands: int) -> Peer:
    words = "VBD, 10 iterations, EA and GA / 100, single precision"
    name = f"Newton {version('newton')}"
    return Peer(name, words, segments, steps, strands, lambda scene, count: Cables(scene, count, segments, steps))


class Cables:
    """Strands of Newton; see `Strands`."""

    def __init__(self, scene: Hanging, strands: int, segments: int, steps: int) -> None:
        warp = import_module("warp")
        warp.config.quiet = True
        newton = import_module("newton")
        self._steps, self._segments, self._drag = steps, segments, scene.drag
        self._size = scene.centred(segments)
        builder = newton.ModelBuilder(gravity=(0.0, -scene.gravity, 0.0))
        fibre = scene.material
        shear = 0.9 * fibre.axial / (2 * (1 + fibre.poisson))
        rod = newton.Rod(
            (np.arange(segments + 1)[:, None] - 0.5) * self._size * scene.direction,
            radius=fibre.diameter / 2,
            stretch_rigidity=MILLIGRAM * fibre.axial,
            shear_rigidity=MILLIGRAM * shear,
            bend_rigidity=MILLIGRAM * fibre.bending,
            twist_rigidity=MILLIGRAM * fibre.torsion,
        )
        mass = MILLIGRAM * fibre.line_density * self._size
        inertia = mass * np.full(3, self._size**2 / 12)  # about the fibre, too: in single precision
        none = newton.ModelBuilder.ShapeConfig(density=0.0, has_shape_collision=False, has_particle_collision=False)
        for _ in range(strands):
            bodies, _ = builder.add_rod(rod=rod, cfg=none)
            for n, body in enumerate(bodies):
                free = 1.0 if n else 0.0
                builder.body_mass[body] = free * mass
                builder.body_inv_mass[body] = free / mass
                builder.body_inertia[body] = warp.mat33(*np.diag(free * inertia).ravel())
                builder.body_inv_inertia[body] = warp.mat33(*np.diag(free / inertia).ravel())
        builder.color()
        model = builder.finalize(device="cpu")
        self._solver = newton.solvers.SolverVBD(model, iterations=10)
        self._state, self._next, self._control = model.state(), model.state(), model.control()

    def advance(self) -> None:
        """Advance by a frame."""
        step = FRAME / self._steps
        for _ in range(self._steps):
            self._state.clear_forces()
            self._solver.step(self._state, self._next, self._control, None, step)
            self._state, self._next = self._next, self._state
            if self._drag > 0.0:
                velocities = self._state.body_qd.numpy()  # shared with the solver, on a processor
                velocities *= np.exp(-self._drag * step)

    def points(self) -> np.ndarray:
        """Middles of the segments of the first strand, and its tip [m], (n, 3)."""
        poses = self._state.body_q.numpy()[: self._segments]
        middles = poses[:, :3].astype(float)
        x, y, z, w = poses[-1, 3:]
        along = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
        return np.vstack([middles, middles[-1] + self._size / 2 * along])
