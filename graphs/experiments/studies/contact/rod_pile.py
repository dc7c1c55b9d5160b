"""Rods of two points, laid crosswise on a fixed row: the smallest pile."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy import sparse

from hairpipe.contact.contact_points import REACH, Contacts, find_contacts
from hairpipe.contact.repulsion import anchor, linearise, no_shear, sweep
from hairpipe.geometry.proximity import near_pairs
from hairpipe.laws.settings import Collisions
from hairpipe.solve.couplings import Couplings, couplings_at, matrices
from hairpipe.solve.interactions import Prediction
from hairpipe.values.hair import Shear

LENGTH, MASS, GRAVITY = 6e-3, 4e-8, 9.81
"""Length of a rod [m], mass of each of its points [kg], as for a hair of 0.11 mm, and gravity [m/s^2]."""


@dataclass(eq=False)
class Pile:
    """Rods at an instant; those of the lowest layer are held.

    points, velocities  two of every rod, four of every layer [m], [m/s], (4 layers + 4, 3)
    shear               elongations of contacts
    """

    points: np.ndarray
    velocities: np.ndarray
    shear: Shear = field(default_factory=no_shear)

    @property
    def masses(self) -> np.ndarray:
        """Of the points, inf where they are held [kg], (points,)."""
        return np.where(np.arange(len(self.points)) < 4, np.inf, MASS)

    @property
    def offsets(self) -> np.ndarray:
        """Every rod is a strand, (rods+1,) int32."""
        return np.arange(0, len(self.points) + 1, 2).astype(np.int32)

    def contacts(self, law: Collisions) -> Contacts:
        """Find what touches or may touch in a step."""
        pairs = near_pairs(self.points, self.offsets, REACH * law.thickness.value)
        return find_contacts(pairs, self.points, self.velocities, law)


def pile_up(heights: np.ndarray) -> Pile:
    """Lay two parallel rods at every height [m], those of each layer across those below."""
    ends = np.array([[-0.5, 0, -0.25], [0.5, 0, -0.25], [-0.5, 0, 0.25], [0.5, 0, 0.25]]) * LENGTH
    across = ends[:, ::-1]
    layers = [(across if k % 2 else ends) + [0.0, height, 0.0] for k, height in enumerate(heights)]
    points = np.concatenate(layers)
    return Pile(points, np.zeros_like(points))


def resting(layers: int, law: Collisions) -> np.ndarray:
    """Heights [m] at which springs carry what lies above: every contact half a rod of each layer, (layers+1,)."""
    loads = MASS * GRAVITY * np.arange(layers, 0, -1)
    return np.concatenate([[0.0], np.cumsum(law.thickness.value - loads / law.stiffness)])


def opening(contacts: Contacts, velocities: np.ndarray) -> np.ndarray:
    """Speed at which each contact opens, negative where it closes, n.u [m/s], (n,)."""
    relative_speeds = relative(contacts, len(velocities)) @ velocities.ravel()
    return (contacts.normals * relative_speeds.reshape(-1, 3)).sum(axis=1)


def sweep_over(pile: Pile, law: Collisions, dt: float, *, elastic: bool) -> None:
    """Change velocities by `law.sweeps` over all pairs, in place."""
    pairs = near_pairs(pile.points, pile.offsets, REACH * law.thickness.value)
    sweep(pairs, pile.points, pile.velocities, pile.masses, law, dt, elastic=elastic)


class PileSystem(NamedTuple):
    """The linear system A dv = b of the free points of a pile, its contacts and their anchors, see `coulomb.py`."""

    A: sparse.csr_matrix
    b: np.ndarray
    contacts: Contacts
    anchors: np.ndarray


def system(pile: Pile, law: Collisions, dt: float) -> PileSystem:
    """Make the linear system (M + J^T M_c J) dv = J^T push of the free points, linearised at x + dt v."""
    masses = pile.masses
    free = np.arange(12 * (len(pile.points) // 4 - 1)) + 12
    contacts = pile.contacts(law)
    couplings = couplings_at(contacts)
    count = len(pile.points)
    at = Prediction(
        points=pile.points + dt * pile.velocities,
        velocities=pile.velocities,
        lagged_velocity=pile.velocities,
        masses=masses,
        weights=np.full(count, dt),
        active=np.ones(count, np.bool_),
        span=dt,
        time=dt,
        seconds=dt,
    )
    anchors = anchor(contacts, pile.points, pile.shear, law)
    linearise(contacts, anchors, at, law, couplings)
    couplings = Couplings(*(array[couplings.acts] for array in couplings))
    J = relative(couplings, len(pile.points))[:, free]
    A = MASS * sparse.eye(len(free)) + J.T @ stiffness(couplings) @ J
    return PileSystem(sparse.csr_matrix(A), J.T @ couplings.push.ravel(), contacts, anchors)


def relative(couplings: Couplings | Contacts, points: int) -> sparse.csr_matrix:
    """J of all of them, (3 n, 3 points)."""
    (a, b), (s, t) = couplings.segments.T, couplings.fractions.T
    rows = np.tile(np.arange(len(a)), 4)
    weights = (np.concatenate([1 - s, s, t - 1, -t]), (rows, np.concatenate([a, a + 1, b, b + 1])))
    return sparse.csr_matrix(sparse.kron(sparse.csr_matrix(weights, (len(a), points)), sparse.eye(3)))


def stiffness(couplings: Couplings) -> sparse.bsr_matrix:
    """Every M on the diagonal, (3 n, 3 n)."""
    blocks = matrices(couplings)
    count = len(couplings.acts)
    return sparse.bsr_matrix((blocks, np.arange(count), np.arange(count + 1)), (3 * count, 3 * count))
