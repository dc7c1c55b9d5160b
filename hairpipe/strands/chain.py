"""A plain chain: particles on the axis only, edges between them and the bending energy of the rod.

    m_-1  m_0  m_1  ...  m_n

For straight hair without twist: half the particles of the network, and a band of two particles instead of three. It
has no torsion, and its rest shape is straight. The buried segment (m_-1, m_0) defines the direction of the root; the
joint at m_0 represents half a segment of free hair and is twice as stiff, as in the network.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load
from hairpipe.laws.bending import add_bending
from hairpipe.laws.settings import Construction
from hairpipe.laws.stretch import critical_damping, linearise_spring
from hairpipe.strands.assembly import add_spring
from hairpipe.strands.interface import ModelKind, register_model
from hairpipe.strands.layout import Layout, Shape
from hairpipe.strands.material import Fibres
from hairpipe.values import Groom

SHAPE = Shape(reach=2, clamped=2, stride=1)
STRAIGHTEST = np.deg2rad(3.0)
"""Turn between two segments above which a strand is not called straight."""


class Chain(NamedTuple):
    """Constants of every strand; rows are particles from m_-1 to m_n, block after block.

    first            rows of block b are first[b]:first[b+1], (blocks+1,) int64
    mass             [kg], (rows, W)
    inverse_lengths  1 / l0 of the edge to the next particle [1/m], 0 past the end, (rows, 1, W)
    constants        EA of the edge to the next particle [N], and EI / l^3 of the joint there [N/m], (rows, 2, W)
    shape            of a strand
    """

    first: np.ndarray
    mass: np.ndarray
    inverse_lengths: np.ndarray
    constants: np.ndarray
    shape = SHAPE


def build_chain(
    layout: Layout, groom: Groom, fibres: Fibres, construction: Construction, shape: float | np.ndarray
) -> tuple[Chain, np.ndarray]:
    """Make the chains of a groom of strands that are straight at rest; the construction does not affect a chain."""
    rest = layout.empty(3, dtype=np.float64)
    chain = Chain(layout.first, layout.empty(), layout.empty(1), layout.empty(2))
    for blocks in layout.classes():
        places = layout.points(blocks)
        axis = groom.points[places]
        fibre = fibres.of(places)
        particles = np.concatenate([2 * axis[:, :1] - axis[:, 1:2], axis], axis=1)
        edges = np.diff(particles, axis=1)
        lengths = np.linalg.norm(edges, axis=2)
        bent = (np.broadcast_to(shape, len(groom.points))[places] > 0.0).any(axis=1)
        _check_straight((edges / lengths[:, :, None])[bent])
        segment = lengths[:, 1:].mean(1)
        after = SHAPE.segments(axis.shape[1] - 1)
        dense = fibre.segments.line_density[:, after]
        mass = dense * segment[:, None]
        mass[:, 1:] = (dense[:, :-1] + dense[:, 1:]) / 2 * segment[:, None]
        mass[:, -1] /= 2
        inverse = np.zeros((*particles.shape[:2], 1))
        inverse[:, :-1, 0] = 1 / lengths
        layout.scatter(particles, blocks, rest)
        layout.scatter(mass, blocks, chain.mass)
        layout.scatter(inverse, blocks, chain.inverse_lengths)
        constants = np.zeros((*particles.shape[:2], 2))
        constants[:, :, 0] = fibre.segments.axial[:, after]
        constants[:, :-1, 1] = fibre.points.bending / segment[:, None] ** 3
        constants[:, 0, 1] *= 2.0  # Stands for half a segment of free hair, the rest is buried: twice as stiff.
        layout.scatter(constants, blocks, chain.constants)
    return chain, rest


def _check_straight(tangents: np.ndarray) -> None:
    turn = np.arccos(np.clip(np.sum(tangents[:, 1:] * tangents[:, :-1], axis=2), -1, 1)).max(initial=0.0)
    if turn > STRAIGHTEST:
        raise BadInput(
            f"a strand turns by {np.rad2deg(turn):.3g} deg from one segment to the next; a chain is straight at rest",
            where="model",
            right='model = "network"',
        )


@inlined
def _springs(model, p, count):
    return min(1, count - 1 - p)


@inlined
def _add_forces(model, system, at, p, block, terms):
    A, b = system
    x = at.x
    h, hh, damping, _ = terms
    count = x.shape[0]
    row = model.first[block] + p
    if p + 2 < count:
        add_bending(A, b, x, p, load(model.constants, (row, 1)), h, hh)
    if p + 1 < count:
        k, inverse_rest = load(model.constants, (row, 0)), load(model.inverse_lengths, (row, 0))
        mass = model.mass[model.first[block] : model.first[block + 1]]
        c = damping * critical_damping(k, inverse_rest, mass, p, p + 1) if damping > 0.0 else 0.0 * k
        add_spring(A, b, p, 1, linearise_spring(at, p, 1, (k, inverse_rest, c), h, hh))


@inlined
def _constant(model, block, p, offset):
    return load(model.constants, (model.first[block] + p, 0))


CHAIN = register_model(
    ModelKind("chain", Chain, SHAPE, build_chain, _add_forces, _springs, _constant, single_limit=100.0)
)
