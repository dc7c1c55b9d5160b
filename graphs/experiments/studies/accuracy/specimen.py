"""One strand to measure: the model that the simulation would build for it, and what its kernels say of it.

Motions, loads and forces have the unknowns of a row: three components, and of a rod the angle of the edge to the next
node times a length, as `band.py` has it.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.groom.strands import unbound
from hairpipe.solve.sag_free import assemble, tangent
from hairpipe.solve.stage import Iterate
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.interface import StiffnessPart, StrandModel, follow_solve, hold_tip, may_be_lost
from hairpipe.strands.layout import Shape
from hairpipe.strands.material import Material
from hairpipe.strands.network import constants_by_particle
from hairpipe.strands.rod import Rod

STEP = 1e-3
"""Step of the finite differences, over the length of a segment: their truncation error is below rounding."""
_EXACT = int(StiffnessPart.exact)


class Pose(NamedTuple):
    """How a strand stands: rows [m], (rows, 3), and what its model remembers besides, (rows, springs)."""

    x: np.ndarray
    T: np.ndarray


@dataclass(frozen=True, eq=False)
class Specimen:
    """A strand, the same in every lane of its model.

    rest      as groomed
    material  that it is made of
    """

    model: StrandModel
    rest: Pose
    material: Material

    @property
    def shape(self) -> Shape:
        """How rows stand in the strand."""
        return self.model.shape

    @cached_property
    def mass(self) -> np.ndarray:
        """Of the rows [kg], (rows,)."""
        return self.model.mass[:, 0].copy()

    @cached_property
    def segment(self) -> float:
        """Length of a segment [m]."""
        root, first = self.axis(self.rest)[:2]
        return float(np.linalg.norm(first - root))

    @cached_property
    def segments(self) -> int:
        """Number of free segments."""
        return len(self.axis(self.rest)) - 1

    @property
    def tip(self) -> int:
        """Row of the tip."""
        return len(self.mass) - 1 - self.shape.after

    @property
    def lever(self) -> float:
        """Length by which an angle is multiplied to be an unknown [m], where a model has angles."""
        return float(1 / self.model.scale[0, 0, 0]) if isinstance(self.model, Rod) else 1.0

    def axis(self, pose: Pose) -> np.ndarray:
        """Take the points of the strand [m], (segments+1, 3)."""
        return pose.x[self.shape.axis]

    def nothing(self) -> np.ndarray:
        """Make a load or motion of nothing, (rows, unknowns)."""
        return np.zeros((len(self.mass), self.shape.unknowns))

    def weight(self, gravity: np.ndarray) -> np.ndarray:
        """Find the load of gravity [m/s^2], (3,): [N], (rows, unknowns)."""
        load = self.nothing()
        load[:, :3] = self.mass[:, None] * gravity
        return load

    def spun(self, pose: Pose, angles: np.ndarray) -> np.ndarray:
        """Motion that turns rows, and the edges after them, about +Z by angles [rad], (rows,): (rows, unknowns)."""
        way = self.nothing()
        x, y, _ = pose.x.T
        c = np.cos(angles)
        s = np.sin(angles)
        way[:, 0] = (c - 1) * x - s * y
        way[:, 1] = s * x + (c - 1) * y
        way[:, 3:] = self.lever * angles[:, None]
        return way


def straight_specimen(sample: Sample, segments: int) -> Specimen:
    """Make a straight strand from the origin along +Z."""
    return specimen_of(sample, np.arange(segments + 1)[:, None] * [0.0, 0.0, sample.length / segments])


def specimen_of(sample: Sample, points: np.ndarray) -> Specimen:
    """Make a strand of points at equal distances [m], (n+1, 3); BadInput for what its model cannot be."""
    groom = unbound(np.asarray(points, float)[None], np.eye(3, 4)[None])
    hair = build_hair(groom, sample.material, sample.model, sample.construction)
    if sample.constants == "guessed":
        if sample.model != "network":
            raise BadInput(
                f"constants of a {sample.model} cannot be guessed", where="sample.constants", right='"calibrated"'
            )
        unit = sample.material.bending / np.linalg.norm(points[1] - points[0]) ** 2
        joints = np.multiply.outer([1.0, 1.0, sample.construction.altitude], np.full((1, len(points)), unit))
        edges = hair.model.constants[2:-1:2, 0, 0][None]
        hair.model.constants[:] = constants_by_particle(edges, joints)[0, :, :, None]
    T = np.zeros_like(hair.model.inverse_lengths[:, :, 0])
    return Specimen(hair.model, Pose(hair.rest[:, :, 0].copy(), T), sample.material)


def forces(specimen: Specimen, pose: Pose) -> np.ndarray:
    """Forces of a strand's elasticity [N], (rows, unknowns)."""
    return _assemble(specimen, pose)[1]


def stiffness(specimen: Specimen, pose: Pose, step: float = STEP) -> np.ndarray:
    """Second derivatives of the energy [N/m], (m, m), of all rows times unknowns.

    Of springs they are forces differenced, as the matrix of a step leaves out what could make it indefinite, and that
    is what buckling is about; a model whose matrix may be indefinite has them.

    step  of the differences, over the length of a segment
    """
    if may_be_lost(specimen.model):
        matrix = _of_rows(_assemble(specimen, pose)[0])
        end = specimen.shape.unknowns * specimen.tip + 3
        matrix[end:, end:] = 0.0  # what comes after the tip has no equation
        return matrix
    x = _lanes(specimen, pose.x)
    bands = tangent(specimen.model, 0, x, np.full((1, x.shape[2]), step * specimen.segment))[:, :, 0]
    return _symmetric({k: band[: len(band) - k] for k, band in enumerate(bands.T)}, len(bands))


def moved(specimen: Specimen, pose: Pose, way: np.ndarray) -> Pose:
    """Move a strand by a way, (rows, unknowns): pure."""
    x, T = _lanes(specimen, pose.x), _lanes(specimen, pose.T)
    _follow(specimen.model, x, T, _lanes(specimen, way[:, :3]), _lanes(specimen, way))
    return Pose(pose.x + way[:, :3], T[:, :, 0])


def held_at_tip(specimen: Specimen, pose: Pose) -> Pose:
    """Let what a model remembers follow its last rows, which show how the tip is held: pure."""
    T = _lanes(specimen, pose.T)
    _hold_tip(specimen.model, _lanes(specimen, pose.x), T, np.ones((1, T.shape[2])))
    return Pose(pose.x, T[:, :, 0])


def _lanes(specimen: Specimen, values: np.ndarray) -> np.ndarray:
    return np.repeat(values[:, :, None], specimen.model.mass.shape[1], axis=2)


def _assemble(specimen: Specimen, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    A, b = assemble(specimen.model, 0, _lanes(specimen, pose.x), _lanes(specimen, pose.T), _EXACT)
    return A[:, :, 0], b[:, :, 0]


def _of_rows(A: np.ndarray) -> np.ndarray:
    """Return the matrix whose rows hold four rows of an upper triangle, see `banded_angle.py`, (4 rows, 4 rows)."""
    size = 4 * len(A)
    bands = {k: np.zeros(4 * len(A)) for k in range(11)}
    for unknown, first in enumerate((0, 11, 21, 30)):
        for k in range(11 - unknown):
            bands[k][unknown::4] = A[:, first + k]
    return _symmetric({k: band[: size - k] for k, band in bands.items()}, size)


def _symmetric(bands: dict[int, np.ndarray], size: int) -> np.ndarray:
    """Return the symmetric matrix of a size with diagonals k to the right of the first."""
    matrix = np.zeros((size, size))
    for k, band in bands.items():
        i = np.arange(size - k)
        matrix[i, i + k] = matrix[i + k, i] = band
    return matrix


@njit(cache=True)
def _follow(model: Any, x: np.ndarray, T: np.ndarray, dx: np.ndarray, way: np.ndarray) -> None:
    follow_solve(model, 0, Iterate(x, dx, T), dx, way, 1.0)


@njit(cache=True)
def _hold_tip(model: Any, x: np.ndarray, T: np.ndarray, held: np.ndarray) -> None:
    hold_tip(model, 0, x, T, held)
