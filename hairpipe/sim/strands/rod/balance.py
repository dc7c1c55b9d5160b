"""Sag-free rods: natural bends, twists and lengths in equilibrium under weight, from the tip to the root.

A node and the angle of the edge before it have four equations, and the vertex and the edge before them four stresses:
two moments, a torque and a tension. So a strand is solved node by node:

    q1 g1_f + q2 g2_f + q3 g3_f + T tf = F,   q1 g1_b + q2 g2_b + q3 = Q

with g the derivatives of `vertex.py` by the edge f that ends at the node and by its angle, and F and Q the weight and
the contributions from the side of the tip. Then

    k' = k - q / B1,   psi' = psi - q3 / C1,   l' = l / (1 + T / EA)

which is exact. Stiffnesses stay those of the groom's own bends.

Takahashi and Batty, Rest Shape Optimization for Sag-Free DER, 2024, do this by an optimiser.
"""

import numpy as np

from hairpipe.sim.strands import lattice
from hairpipe.sim.strands.interface import StrandModel
from hairpipe.sim.strands.rod.frames import BENDING, GHOST, TENSION, TWISTING


def balance(model: StrandModel, x: np.ndarray, gravity: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the rest state of rods in equilibrium without twist at x [m], (rows, 3, W), under gravity [m/s^2], (3,).

    Returns their rest state and stored values, both (rows, 6, W), and the largest strain of an edge, (blocks, W).
    """
    natural = model.inverse_lengths.copy()
    remembered = np.zeros_like(model.inverse_lengths)
    strains = np.zeros((len(model.first) - 1, x.shape[2]))
    counts = np.diff(model.first)
    for count in np.unique(counts):
        blocks = np.flatnonzero(counts == count)
        rows = (model.first[blocks][:, None] + np.arange(count)).reshape(-1)

        def by_strand(values: np.ndarray, blocks: np.ndarray = blocks, rows: np.ndarray = rows) -> np.ndarray:
            """Return (strands, rows, ...) of (rows, ..., W)."""
            return np.moveaxis(values[rows].reshape(len(blocks), -1, *values.shape[1:]), -1, 1).reshape(
                len(blocks) * x.shape[2], -1, *values.shape[1:-1]
            )

        axial = by_strand(model.constants)[:, :, 0]
        weight = by_strand(model.mass)[:, :, None] * gravity
        rest, tension = _solve(by_strand(x), weight, by_strand(model.inverse_lengths), axial)
        back = rest.reshape(len(blocks), x.shape[2], count, -1)
        natural[rows] = np.moveaxis(back, 1, -1).reshape(len(rows), -1, x.shape[2])
        pulls = np.moveaxis(tension.reshape(len(blocks), x.shape[2], count), 1, -1)
        remembered[rows, TENSION] = pulls.reshape(len(rows), x.shape[2])
        strains[blocks] = np.abs(tension / axial).max(axis=1).reshape(len(blocks), x.shape[2])
    return natural, remembered, strains


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.sum(a * b, axis=-1, keepdims=True)


def _unit(a: np.ndarray) -> np.ndarray:
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def _directors(x: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    """Directors of all edges from the buried one on, without twist, (s, n+1, 3)."""
    shown = x[:, 0] - x[:, GHOST]
    found = [_unit(shown - _dot(shown, tangents[:, 0]) * tangents[:, 0])]
    for i in range(1, tangents.shape[1]):
        found.append(lattice.transport(found[-1], tangents[:, i - 1], tangents[:, i]))
    return np.stack(found, axis=1)


def _solve(x: np.ndarray, weight: np.ndarray, natural: np.ndarray, axial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Balance strands, the first axis of all arrays; return what they have at rest and their tensions [N]."""
    edges = np.diff(x[:, GHOST:-1], axis=1)
    lengths = np.linalg.norm(edges, axis=2, keepdims=True)
    tangents = edges / lengths
    m1 = _directors(x, tangents)
    m2 = np.cross(tangents, m1)
    force = weight.copy()
    torque = np.zeros(weight.shape[:2])
    rest = natural.copy()
    tension = np.zeros(weight.shape[:2])
    for i in range(edges.shape[1] - 1, 0, -1):  # the vertex between edges i - 1 and i, in row i + 1
        te = tangents[:, i - 1]
        tf = tangents[:, i]
        row = i + GHOST
        chi = 1 + _dot(te, tf)
        kb = 2 * np.cross(te, tf) / chi
        tt = (te + tf) / chi
        c1, c2 = (m1[:, i - 1] + m1[:, i]) / chi, (m2[:, i - 1] + m2[:, i]) / chi
        k1 = chi * _dot(c2, kb) / 2
        k2 = -chi * _dot(c1, kb) / 2
        by_e = np.stack([np.cross(tf, c2) - k1 * tt, -np.cross(tf, c1) - k2 * tt, kb / 2], axis=2)
        by_f = np.stack([-np.cross(te, c2) - k1 * tt, np.cross(te, c1) - k2 * tt, kb / 2], axis=2)
        by_e = by_e / lengths[:, i - 1, :, None]
        by_f = by_f / lengths[:, i, :, None]
        by_a, by_b = (
            np.concatenate([-_dot(m1[:, j], kb) / 2, -_dot(m2[:, j], kb) / 2, np.full_like(k1, sign)], axis=1)
            for j, sign in ((i - 1, -1.0), (i, 1.0))
        )
        system = np.zeros((len(x), 4, 4))
        system[:, :3, :3], system[:, :3, 3], system[:, 3, :3] = by_f, tf, by_b
        wanted = np.concatenate([force[:, row + 1], torque[:, row, None]], axis=1)
        found = np.linalg.solve(system, wanted[:, :, None])[:, :, 0]
        q, pull = found[:, :3], found[:, 3:]
        e, f = np.einsum("sck,sk->sc", by_e, q), np.einsum("sck,sk->sc", by_f, q)
        force[:, row] += f - e + pull * tf
        force[:, row - 1] += e
        torque[:, row - 1] -= np.sum(by_a * q, axis=1)
        rest[:, row, 0] = (1 + pull[:, 0] / axial[:, row]) / lengths[:, i, 0]
        rest[:, row, 1:3] = np.concatenate([k1, k2], axis=1) - q[:, :2] / natural[:, row, BENDING, None]
        rest[:, row, 3] = -q[:, 2] / natural[:, row, TWISTING]
        tension[:, row] = pull[:, 0]
    return rest, tension
