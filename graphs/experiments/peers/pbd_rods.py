"""pyPBD: rigid segments, position-based, a direct solver of rods (Deul et al. 2018); PositionBasedDynamics, MIT."""

from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from hairpipe.graphs.experiments.peers.hanging import FRAME, Hanging, Peer

CUBE = """v -1 -1 -1\nv -1 -1 1\nv -1 1 -1\nv -1 1 1\nv 1 -1 -1\nv 1 -1 1\nv 1 1 -1\nv 1 1 1
f 1 2 4\nf 1 4 3\nf 5 7 8\nf 5 8 6\nf 1 5 6\nf 1 6 2\nf 3 4 8\nf 3 8 7\nf 1 3 7\nf 1 7 5\nf 2 6 8\nf 2 8 4
"""
"""A shape, which its rigid bodies must have; masses are given."""
GRAVITY = 9.81
"""Its gravity [m/s^2]; another one is the same motion in slower time, of fibres as much stiffer."""


def peers() -> list[Peer]:
    """List the settings that are compared: a solve a step, which its direct solver needs no more of."""
    return [_peer(steps) for steps in (4, 16, 64)]


def _peer(steps: int) -> Peer:
    words = "direct solver of rods, one solve a step, rigid segments"
    name = f"pyPBD {version('pypbd')}"
    return Peer(name, words, 50, steps, 100, lambda scene, strands: Rods(scene, strands, 50, steps))


class Rods:
    """Strands of pyPBD, of which one scene lives at a time; see `Strands`."""

    def __init__(self, scene: Hanging, strands: int, segments: int, steps: int) -> None:
        self._pbd = pbd = import_module("pypbd")
        self._steps = steps
        slow = float(np.sqrt(GRAVITY / scene.gravity))
        self._step = FRAME / slow / steps
        self._kept = float(np.exp(-scene.drag * FRAME / steps))
        self._young = scene.material.young * slow**2
        self._segments = segments
        self._half = scene.centred(segments) / 2
        simulation = pbd.Simulation.getCurrent()
        if simulation.getModel() is None:
            simulation.initDefault()
        self._model = simulation.getModel()
        self._model.cleanup()
        self._stepper = simulation.getTimeStep()
        self._stepper.setValueUInt(pbd.TimeStepController.NUM_SUB_STEPS, 1)
        self._stepper.setValueUInt(pbd.TimeStepController.MAX_ITERATIONS, 1)
        self._bodies = [body for _ in range(strands) for body in self._strand(scene)]

    def _strand(self, scene: Hanging) -> list:
        pbd = self._pbd
        fibre = scene.material
        size = 2 * self._half
        first = len(self._model.getRigidBodies())
        with TemporaryDirectory() as folder:
            file = Path(folder) / "cube.obj"
            file.write_text(CUBE)
            shape, mesh = pbd.OBJLoader.loadObjToMesh(str(file), [1.0, 1.0, 1.0])
        beyond = np.array([0.0, 0.0, 1.0])
        turn = np.stack([np.cross(scene.direction, beyond), scene.direction, beyond], axis=1)
        thick = fibre.diameter
        mass = fibre.line_density * size
        bodies = []
        for n in range(self._segments):
            place = n * size * scene.direction
            body = self._model.addRigidBody(fibre.density, shape, mesh, place, turn, [thick, size, thick])
            body.setMass(mass if n else 0.0)
            self._end = np.array(body.getRotationMatrix()).T @ scene.direction  # an axis, which pyPBD chooses
            body.setInertiaTensor(mass * np.where(np.abs(self._end) > 0.5, thick**2 / 8, size**2 / 12))
            bodies.append(body)
        joints = range(self._segments - 1)
        self._model.addDirectPositionBasedSolverForStiffRodsConstraint(
            [(first + n, first + n + 1) for n in joints],
            [(n + 0.5) * size * scene.direction for n in joints],
            *([value] * len(joints) for value in (thick / 2, size, self._young, self._young / (2 + 2 * fibre.poisson))),
        )
        return bodies

    def advance(self) -> None:
        """Advance by a frame."""
        self._pbd.TimeManager.getCurrent().setTimeStepSize(self._step)
        for _ in range(self._steps):
            self._stepper.step(self._model)
            if self._kept < 1.0:
                for body in self._bodies:
                    body.setVelocity(self._kept * np.array(body.getVelocity()))
                    body.setAngularVelocity(self._kept * np.array(body.getAngularVelocity()))

    def points(self) -> np.ndarray:
        """Middles of the segments of the first strand, and its tip [m], (n, 3)."""
        bodies = self._bodies[: self._segments]
        middles = np.array([body.getPosition() for body in bodies])
        end = np.array(bodies[-1].getRotationMatrix()) @ self._end
        return np.vstack([middles, middles[-1] + self._half * end])
