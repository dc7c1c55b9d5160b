"""Equilibria of one strand under dead loads, however it is held, and its stiffness there.

The stiffness is that of the kernels' forces: they are differentiated numerically, since the matrix of a step leaves out
what could make it indefinite, and that is what buckling is about.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.studies.accuracy.specimen import Specimen, forces

_STEP = 1e-3
"""Step of the finite differences, over the length of a segment: their truncation error is below rounding."""
_TOLERANCE = 1e-8
"""Largest residual force, over the load and E I / L^2, at which a search has converged."""
_MOST_STEPS, _MOST_STALLED = 400, 150
_FURTHEST = 0.5
"""Way of a particle in one step of Newton's method, over the length of a segment."""


class Balance(NamedTuple):
    """Where a search for equilibrium ended: particles [m], (p, 3), and the forces left over the load, 1."""

    positions: np.ndarray
    residual: float

    @property
    def found(self) -> bool:
        """Whether it is an equilibrium."""
        return self.residual < 10 * _TOLERANCE


def stiffness(specimen: Specimen, x: np.ndarray, step: float = _STEP) -> np.ndarray:
    """Second derivatives of the energy [N/m], (3p, 3p), at x [m], (p, 3).

    step  of the differences, over the length of a segment
    """
    from hairpipe.sim.statics.hessian import tangent

    lanes = np.repeat(x[:, :, None], specimen.model.mass.shape[1], axis=2)
    bands = tangent(specimen.model, 0, lanes, np.full((1, lanes.shape[2]), step * specimen.segment))[:, :, 0]
    matrix = np.zeros((3 * len(x), 3 * len(x)))
    for k, band in enumerate(bands.T):
        i = np.arange(len(band) - k)
        matrix[i, i + k] = matrix[i + k, i] = band[: len(i)]
    return matrix


def motions(specimen: Specimen, slides: bool = False) -> np.ndarray:
    """Motions that are left to a strand clamped at its root, as columns (3p, m).

    slides  its last three particles are held, too, but for a common motion along +Z
    """
    count = len(specimen.rest)
    last = count - 3 if slides else count
    free = np.eye(3 * count)[:, 9 : 3 * last]
    if not slides:
        return free
    along = np.zeros((count, 3))
    along[last:, 2] = 1
    return np.column_stack([free, along.reshape(-1)])


def balance(specimen: Specimen, x: np.ndarray, load: np.ndarray, free: np.ndarray) -> Balance:
    """Find the equilibrium that a strand comes to from x [m] under dead loads [N], both (p, 3).

    free  motions left to it, (3p, m)

    Newton's method; where the stiffness is not positive it is raised until it is, so that the energy falls.
    """
    from scipy.linalg import cho_solve

    length = specimen.segment * specimen.segments
    scale = np.abs(load).sum() + specimen.material.bending / length**2
    best, stalled, residual = np.inf, 0, np.inf
    for _ in range(_MOST_STEPS):
        left = free.T @ (forces(specimen, x[None])[0] + load).reshape(-1)
        residual = float(np.abs(left).max() / scale)
        stalled = 0 if residual < 0.7 * best else stalled + 1
        best = min(best, residual)
        if residual < _TOLERANCE or stalled > _MOST_STALLED:
            break
        way = (free @ cho_solve((raised(free.T @ stiffness(specimen, x) @ free), True), left)).reshape(-1, 3)
        x = x + way * min(1, _FURTHEST * specimen.segment / np.abs(way).max())
    return Balance(x, residual)


def raised(matrix: np.ndarray) -> np.ndarray:
    """Cholesky factor of a matrix, to which as much of the identity is added as it needs to have one."""
    more = 0.0
    while True:
        try:
            return np.linalg.cholesky(matrix + more * np.eye(len(matrix)))
        except np.linalg.LinAlgError:
            more = max(4 * more, 1e-9 * float(np.abs(np.diag(matrix)).mean()))
