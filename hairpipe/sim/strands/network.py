"""The model of a strand in Sec. 3.2 of Selle, Lentine, Fedkiw 2008: edge, bending, torsion and altitude springs."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numba.core.extending import overload

from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import load
from hairpipe.sim.layout import Layout
from hairpipe.sim.material import Material
from hairpipe.sim.strands import lattice
from hairpipe.sim.strands.calibration import spring_constants, works
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.curl import Fit, fit_curls
from hairpipe.sim.strands.forces.altitude import linearise_altitude
from hairpipe.sim.strands.forces.assembly import add_spring, add_tetrahedron
from hairpipe.sim.strands.forces.spring import critical_damping, linearise_spring
from hairpipe.sim.strands.interface import Shape, add_forces, is_model, shape_of, spring_constant, springs_from

SHAPE = Shape(reach=3, clamped=lattice.CLAMPED, stride=2)


class Network(NamedTuple):
    """Constants of every strand's springs; rows are particles in the order of the lattice, block after block.

    first            rows of block b are first[b]:first[b+1], (blocks+1,) int64
    mass             [kg], (rows, W)
    inverse_lengths  1 / l0 of the springs to the next three particles [1/m], 0 past the end, (rows, 3, W)
    inverse_heights  signed 1 / h0 of the seven altitude springs [1/m], (rows, 7, W)
    constants        edge, bending, torsion and altitude constant [N], (blocks, 4, W)
    shape            of a strand
    """

    first: np.ndarray
    mass: np.ndarray
    inverse_lengths: np.ndarray
    inverse_heights: np.ndarray
    constants: np.ndarray
    shape = SHAPE


def build_network(
    layout: Layout, points: np.ndarray, frames: np.ndarray, material: Material, construction: Construction
) -> tuple[Network, np.ndarray]:
    """Make the network whose rest shape is the groom.

    points   of the groom [m], (p, 3)
    frames   of its roots, whose first three columns count, (strands, 3, 3 or more)
    returns  the network, and its particles at rest [m], (rows, 3, W)
    """
    rest = layout.empty(3, dtype=np.float64)
    network = Network(layout.first, layout.empty(), layout.empty(3), layout.empty(7), layout.empty_blocks(4))
    for blocks, axis in layout.classes(points):
        length = np.linalg.norm(np.diff(axis, axis=1), axis=2).mean(1)
        normals = lattice.first_normals(axis, frames[layout.strands[blocks].reshape(-1)])
        fit = _fit(axis, normals, length, material, construction)
        particles, constants = (
            lattice.perturb(axis, fit.normals, fit.turns),
            spring_constants(material, construction, length),
        )
        constants[1:] *= fit.factors
        segments = axis.shape[1] - 1
        masses = lattice.masses(length, segments, material.line_density, construction.off_axis_mass)
        layout.fill(rest, blocks, particles)
        layout.fill(network.mass, blocks, masses)
        layout.fill(network.inverse_lengths, blocks, _inverse(lattice.rest_lengths(particles)))
        layout.fill(network.inverse_heights, blocks, _inverse(lattice.rest_heights(particles)))
        layout.fill_blocks(network.constants, blocks, constants)
    return network, rest


def _fit(
    axis: np.ndarray, normals: np.ndarray, length: np.ndarray, material: Material, construction: Construction
) -> Fit:
    """Fit the lattice to curls as if it had all that the construction leaves out."""
    turn = float(np.deg2rad(construction.turn))
    if not works(turn):
        return Fit(normals, np.full((len(axis), 1), turn), np.ones(len(axis)))
    whole = spring_constants(material, replace(construction, bending=1.0, torsion=1.0), length)
    return fit_curls(axis, normals, turn, whole, material)


def _inverse(values: np.ndarray) -> np.ndarray:
    return np.divide(1.0, values, out=np.zeros_like(values), where=values != 0)


@inlined
def _constant(constants, block, p, offset):  # noqa: ANN001, ANN202
    """Constant of the spring from particle p to p + offset: edge, bending or torsion, see the lattice."""
    if offset == 3:
        return _at_root(p) * load(constants, (block, 2))
    if offset == 2 and p % 2:
        return _at_root(p) * load(constants, (block, 1))
    return load(constants, (block, 0))


@inlined
def _at_root(p: int) -> float:
    """Stiffness across m_0, half of whose joint is buried."""
    return 2.0 if p < 2 else 1.0


@inlined
def _springs(p: int, count: int) -> int:
    return min(3, count - 1 - p)


@inlined
def _spring(model, x, v, T, p, block, offset, h, hh, damping):  # noqa: ANN001, ANN202
    """Linearise the spring from particle p to p + offset."""
    first = model.first[block]
    k, inverse_rest = _constant(model.constants, block, p, offset), load(model.inverse_lengths, (first + p, offset - 1))
    c = 0.0 * k
    if damping > 0.0:
        c = damping * critical_damping(k, inverse_rest, model.mass, first + p, first + p + offset)
    return linearise_spring(x, v, T, p, offset, k, inverse_rest, c, h, hh)


@inlined
def _add_forces(model, A, b, x, v, T, p, block, h, hh, damping):  # noqa: ANN001, ANN202
    count = x.shape[0]
    if p + 3 < count:
        heights = model.inverse_heights[model.first[block] : model.first[block + 1]]
        altitude = linearise_altitude(x, p, _at_root(p) * load(model.constants, (block, 3)), heights, h, hh)
        spring1 = _spring(model, x, v, T, p, block, 1, h, hh, damping)
        spring2 = _spring(model, x, v, T, p, block, 2, h, hh, damping)
        spring3 = _spring(model, x, v, T, p, block, 3, h, hh, damping)
        add_tetrahedron(A, b, p, altitude, spring1, spring2, spring3)
    else:
        for offset in range(1, count - p):
            add_spring(A, b, p, offset, _spring(model, x, v, T, p, block, offset, h, hh, damping))


@overload(add_forces, strict=False)
def _network_forces(
    model: Any, A: Any, b: Any, x: Any, v: Any, T: Any, p: Any, block: Any, h: Any, hh: Any, damping: Any
) -> Callable | None:
    if is_model(model, Network):
        return lambda model, A, b, x, v, T, p, block, h, hh, damping: _add_forces(
            model, A, b, x, v, T, p, block, h, hh, damping
        )
    return None


@overload(shape_of, strict=False)
def _network_shape(model: Any) -> Callable | None:
    return (lambda model: SHAPE) if is_model(model, Network) else None


@overload(springs_from, strict=False)
def _network_springs(model: Any, p: Any, count: Any) -> Callable | None:
    return (lambda model, p, count: _springs(p, count)) if is_model(model, Network) else None


@overload(spring_constant, strict=False)
def _network_constant(model: Any, block: Any, p: Any, offset: Any) -> Callable | None:
    if is_model(model, Network):
        return lambda model, block, p, offset: _constant(model.constants, block, p, offset)
    return None
