"""Equilibria of one strand under dead loads, however it is held."""

from typing import NamedTuple

import numpy as np

from hairpipe.graphs.experiments.studies.accuracy.specimen import Pose, Specimen, forces, moved, stiffness

_TOLERANCE = 1e-8
"""Largest residual force, over the load and E I / L^2, at which a search has converged."""
_MOST_STEPS, _MOST_STALLED = 400, 150
_FURTHEST = 0.5
"""Way of a particle in one step of Newton's method, over the length of a segment."""


class Balance(NamedTuple):
    """Where a search for equilibrium ended, and the forces left over the load, 1."""

    pose: Pose
    residual: float

    @property
    def found(self) -> bool:
        """Whether it is an equilibrium."""
        return self.residual < 10 * _TOLERANCE


def motions(specimen: Specimen, slides: bool = False) -> np.ndarray:
    """Motions that are left to a strand clamped at its root, as columns (rows times unknowns, m).

    slides  its last rows, as many as hold the root, are held, too, but for a common motion along +Z
    """
    nothing = specimen.nothing()
    clamped = specimen.shape.clamped
    count, unknowns = nothing.shape
    angles = unknowns - 3  # that of the last edge held at the root is free, and the tip has none
    last = count - clamped if slides else count - specimen.shape.after
    free = np.eye(nothing.size)[:, unknowns * clamped - angles : unknowns * last - (0 if slides else angles)]
    if not slides:
        return free
    nothing[last:, 2] = 1
    return np.column_stack([free, nothing.reshape(-1)])


def balance(specimen: Specimen, pose: Pose, load: np.ndarray, free: np.ndarray) -> Balance:
    """Find the equilibrium that a strand comes to from a pose under dead loads [N], (rows, unknowns).

    free  motions left to it, see `motions`

    Newton's method; where the stiffness is not positive it is raised until it is, so that the energy falls.
    """
    from scipy.linalg import cho_solve

    length = specimen.segment * specimen.segments
    scale = np.abs(load).sum() + specimen.material.bending / length**2
    best = np.inf
    stalled = 0
    residual = np.inf
    for _ in range(_MOST_STEPS):
        left = free.T @ (forces(specimen, pose) + load).reshape(-1)
        residual = float(np.abs(left).max() / scale)
        stalled = 0 if residual < 0.7 * best else stalled + 1
        best = min(best, residual)
        if residual < _TOLERANCE or stalled > _MOST_STALLED:
            break
        way = free @ cho_solve((raised(free.T @ stiffness(specimen, pose) @ free), True), left)
        way *= min(1, _FURTHEST * specimen.segment / np.abs(way).max())
        pose = moved(specimen, pose, way.reshape(load.shape))
    return Balance(pose, residual)


def least_stiffness(specimen: Specimen, pose: Pose, free: np.ndarray) -> float:
    """Smallest stiffness of a strand against its free motions [N/m], see `motions`: at its zero the strand buckles."""
    from scipy.linalg import eigh

    matrix = free.T @ stiffness(specimen, pose) @ free
    return float(eigh(matrix, eigvals_only=True, subset_by_index=[0, 0])[0])


def raised(matrix: np.ndarray) -> np.ndarray:
    """Cholesky factor of a matrix, to which as much of the identity is added as it needs to have one."""
    more = 0.0
    while True:
        try:
            return np.linalg.cholesky(matrix + more * np.eye(len(matrix)))
        except np.linalg.LinAlgError:
            more = max(4 * more, 1e-9 * float(np.abs(np.diag(matrix)).mean()))
