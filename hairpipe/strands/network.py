"""The model of a strand in Sec. 3.2 of Selle, Lentine, Fedkiw 2008: edge, bending, torsion and altitude springs.

A bound on the highest frequency of the springs of a strand, which limits an explicit step.

    w^2 <= max_p sum_s 4 k_s / (m_p l0_s),   over the springs s at a free particle p

Source: Gershgorin's theorem on M^-1 K, with k/l0 the stiffness of a spring at rest along its direction.
"""

from dataclasses import replace
from typing import NamedTuple
from warnings import warn

import numpy as np
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.curl import curls_of
from hairpipe.geometry.simd import load, store
from hairpipe.laws.altitude import linearise_altitude
from hairpipe.laws.settings import Construction
from hairpipe.laws.stretch import critical_damping, linearise_spring
from hairpipe.strands import lattice
from hairpipe.strands.assembly import add_spring, add_tetrahedron
from hairpipe.strands.calibration import Fit, edge_constants, fit_curls, softenings, spring_constants, works
from hairpipe.strands.interface import ModelKind, StrandModel, register_model, shape_of, spring_constant, springs_from
from hairpipe.strands.lattice import unbent
from hairpipe.strands.layout import Layout, Shape
from hairpipe.strands.material import Fibre, Fibres
from hairpipe.values import Groom
from hairpipe.values.groom import strand_lengths
from hairpipe.values.strand_arrays import name_strands

SHAPE = Shape(reach=3, clamped=lattice.CLAMPED, stride=2)


class Network(NamedTuple):
    """Constants of every strand's springs; rows are particles in the order of the lattice, block after block.

    first            rows of block b are first[b]:first[b+1], (blocks+1,) int64
    mass             [kg], (rows, W)
    inverse_lengths  1 / l0 of the springs to the next three particles [1/m], 0 past the end, (rows, 3, W)
    inverse_heights  signed 1 / h0 of the seven altitude springs [1/m], (rows, 7, W)
    constants        of the springs to the next three particles, and of the altitude [N], (rows, 4, W)
    shape            shape of a strand
    """

    first: np.ndarray
    mass: np.ndarray
    inverse_lengths: np.ndarray
    inverse_heights: np.ndarray
    constants: np.ndarray
    shape = SHAPE


def build_of_groom(
    layout: Layout, groom: Groom, fibres: Fibres, construction: Construction, shape: float | np.ndarray
) -> tuple[Network, np.ndarray]:
    """Make the networks of a groom, see `build_network`."""
    short = least_softenings(groom, fibres) < 1.0
    if short.any():
        size = f"segments of {mean_segments(groom)[short].min():.2g} m, hair of {fibres.diameter:g} m"
        raise BadInput(
            f"{size}: {name_strands(groom.ids[short])}",
            where="groom",
            right="segments longer than hair is thick: fewer of them, or those strands left out",
        )
    return build_network(layout, groom.points, groom.root_frames, fibres, construction, shape)


def warn_of_softening(groom: Groom, fibres: Fibres) -> None:
    """Warn which strands are softened less than the material is, as their segments are too short for that."""
    found = least_softenings(groom, fibres)
    less = found < fibres.softening
    if less.any():
        message = f"{np.count_nonzero(less)} of {len(less)} strands have segments too short for this softening"
        worst = f"they are softened by {found.min():.3g} or more: {name_strands(groom.ids[less])}"
        warn(f"material.softening = {fibres.softening:g}: {message}, {worst}", stacklevel=3)


def warn_of_curls(groom: Groom) -> None:
    """Warn of curls of one turn or more, for which a network is less accurate than a rod."""
    curls = curls_of(groom)
    if len(curls):
        message = f"{len(curls)} of {len(groom.ids)} strands are curls: {name_strands(groom.ids[curls])}"
        off = "their sag has an error of up to 10 %, or they do not come to rest"
        warn(f'model = "network": {message}; {off} (model = "rod")', stacklevel=3)


def warn_of_network(groom: Groom, fibres: Fibres) -> None:
    """Warn of what a network does not take over of a material, and of a shape."""
    warn_of_softening(groom, fibres)
    warn_of_curls(groom)


def mean_segments(groom: Groom) -> np.ndarray:
    """Return the mean length of the segments of every strand [m], (strands,); pure."""
    return strand_lengths(groom.points, groom.offsets) / (np.diff(groom.offsets) - 1)


def least_softenings(groom: Groom, fibres: Fibres) -> np.ndarray:
    """Return the smallest softening along every strand, (strands,); pure."""
    lengths = np.repeat(mean_segments(groom), np.diff(groom.offsets))
    found = softenings(fibres.of(np.arange(len(lengths))).points, lengths)
    return np.minimum.reduceat(found, groom.offsets[:-1])


def build_network(
    layout: Layout,
    points: np.ndarray,
    frames: np.ndarray,
    fibres: Fibres,
    construction: Construction,
    shape: float | np.ndarray = 1.0,
) -> tuple[Network, np.ndarray]:
    """Make the network of a groom."""
    rest = layout.empty(3, dtype=np.float64)
    network = Network(layout.first, layout.empty(), layout.empty(3), layout.empty(7), layout.empty(4))
    for blocks in layout.classes():
        places = layout.points(blocks)
        axis = points[places]
        fibre = fibres.of(places)
        length = np.linalg.norm(np.diff(axis, axis=1), axis=2).mean(1)
        normals = lattice.first_normals(axis, frames[layout.strands[blocks].reshape(-1)])
        after = SHAPE.segments(axis.shape[1] - 1)
        straightened = unbent(axis, normals, np.broadcast_to(shape, len(points))[places])
        fit = _fit(straightened, normals, length, fibre, construction)
        particles, resting = (lattice.perturb(shape, fit.normals, fit.turns) for shape in (axis, straightened))
        edges = edge_constants(fibre.segments, length[:, None])
        joints = spring_constants(fibre.points, construction, length[:, None])[1:] * fit.factors[:, None]
        masses = lattice.masses(length, fibre.segments.line_density[:, after], construction.off_axis_mass)
        layout.scatter(particles, blocks, rest)
        layout.scatter(masses, blocks, network.mass)
        layout.scatter(_inverse(lattice.rest_lengths(resting)), blocks, network.inverse_lengths)
        layout.scatter(_inverse(lattice.rest_heights(resting)), blocks, network.inverse_heights)
        layout.scatter(constants_by_particle(edges, joints), blocks, network.constants)
    return network, rest


def constants_by_particle(edges: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Return the constants of the springs to the next three particles, and of the altitude [N], (s, 2n+3, 4); pure.

    edges   constants of edges, (s, n)
    joints  bending, torsion and altitude constants at the points, (3, s, n+1): springs of both particles before a
            point bend at it

    Springs across m_0, half of whose joint is buried, are twice as stiff.
    """
    count = edges.shape[1]
    rows = np.arange(SHAPE.count(count))
    edge = edges[:, SHAPE.segments(count)]
    bending, torsion, altitude = joints[:, :, np.minimum(rows // 2, count)]
    found = np.stack([edge, np.where(rows % 2, bending, edge), torsion, altitude], axis=-1)
    found[:, :2, 2:] *= 2.0
    found[:, 1, 1] *= 2.0
    return found


def _fit(axis: np.ndarray, normals: np.ndarray, length: np.ndarray, fibre: Fibre, construction: Construction) -> Fit:
    """Fit the lattice to curls as if it had all that the construction leaves out."""
    turn = float(np.deg2rad(construction.turn))
    if not works(turn):
        return Fit(normals, np.full((len(axis), 1), turn), np.ones(len(axis)))
    edges = edge_constants(fibre.segments, length[:, None])
    joints = spring_constants(fibre.points, replace(construction, bending=1.0, torsion=1.0), length[:, None])[1:]
    return fit_curls(axis, normals, turn, constants_by_particle(edges, joints), fibre.points)


def _inverse(values: np.ndarray) -> np.ndarray:
    return np.divide(1.0, values, out=np.zeros_like(values), where=values != 0)


@inlined
def _constant(model, block, p, offset):
    """Constant of the spring from particle p to p + offset: edge, bending or torsion, see the lattice."""
    return load(model.constants, (model.first[block] + p, offset - 1))


@inlined
def _springs(model, p, count):
    return min(3, count - 1 - p)


@inlined
def _spring(model, at, p, block, offset, terms):
    """Linearise the spring from particle p to p + offset."""
    first = model.first[block]
    k = _constant(model, block, p, offset)
    inverse_rest = load(model.inverse_lengths, (first + p, offset - 1))
    c = 0.0 * k
    if terms.damping > 0.0:
        c = terms.damping * critical_damping(k, inverse_rest, model.mass, first + p, first + p + offset)
    return linearise_spring(at, p, offset, (k, inverse_rest, c), terms.h, terms.hh)


@inlined
def _add_forces(model, system, at, p, block, terms):
    A, b = system
    x = at.x
    count = x.shape[0]
    if p + 3 < count:
        heights = model.inverse_heights[model.first[block] : model.first[block + 1]]
        k = load(model.constants, (model.first[block] + p, 3))
        altitude = linearise_altitude(x, p, k, heights, terms.h, terms.hh)
        spring1 = _spring(model, at, p, block, 1, terms)
        spring2 = _spring(model, at, p, block, 2, terms)
        spring3 = _spring(model, at, p, block, 3, terms)
        add_tetrahedron(A, b, p, altitude, spring1, spring2, spring3)
    else:
        for offset in range(1, count - p):  # The last three particles begin no tetrahedron.
            add_spring(A, b, p, offset, _spring(model, at, p, block, offset, terms))


NETWORK = register_model(
    ModelKind(
        "network",
        Network,
        SHAPE,
        build_of_groom,
        _add_forces,
        _springs,
        _constant,
        warn=warn_of_network,
        single_limit=300.0,
    )
)


def highest_frequency(model: StrandModel) -> float:
    """Bound the angular frequency of springs [rad/s]."""
    return float(np.sqrt(stiffest_springs(model)[0]))


@njit(cache=True)
def stiffest_springs(model):
    """Find the largest sum of 4 k / (m l0) over the springs at a free particle [1/s^2], its block and lane."""
    stiffest, where, which = 0.0, 0, 0
    for block in range(len(model.first) - 1):
        first = model.first[block]
        count = model.first[block + 1] - model.first[block]
        sums = np.zeros((count, model.mass.shape[1]))
        k = np.empty((1, model.mass.shape[1]), model.mass.dtype)
        for p in range(count):
            for o in range(1, springs_from(model, p, count) + 1):
                store(k, (0,), spring_constant(model, block, p, o))
                stiffness = 4.0 * k[0] * model.inverse_lengths[first + p, o - 1]
                sums[p] += stiffness / model.mass[first + p]
                sums[p + o] += stiffness / model.mass[first + p + o]
        for lane in range(sums.shape[1]):
            most = sums[shape_of(model).clamped :, lane].max()  # Held particles do not swing.
            if most > stiffest:
                stiffest, where, which = most, block, lane
    return stiffest, where, which
