"""A discrete elastic rod: nodes on the axis, an angle of the material frame on every edge, four unknowns a segment.

    q  x_-1  x_0  x_1  ...  x_n  q'

Accurate, including twist, with half the segments of the network, and independent of orientation. A row has a node and
the angle of the edge to the next. x_-1 lies behind the root and forms the clamp: with a root vertex of half a length
it acts at x_0 exactly. q lies next to x_-1 and defines the director of the buried edge; q' does so next to x_n for a
held tip, and otherwise moves with it. Neither has an equation.

A vertex has B/2l c^4 |k - k'|^2 + C/2l c^2 (psi - psi')^2 (`vertex.py`), with c = cos(phi'/2) of its natural bend phi':
2 tan(phi/2) overestimates a coarse bend, and a curl of 8 segments per turn would be 18 % too stiff. Edges are springs
with a multiplier, as in the network.

We differ from the sources: twist has no inertia, so that its angles are not part of the motion but only of each solve,
and the state of a strand has its twists (`frames.py`). The results of a solve (see `State.T`) are in a row

    0 tension of the edge to the next node [N], 1 twist of the vertex [rad], 2-4 director of the edge, 5 twist of the
    vertex at the start of the last stage [rad]

and in the row of q, 1: repeated steps, 2: duration of the last stage [s], by which the next one predicts twists; 0: no
prediction. At rest a row has

    0 1/l' [1/m], 1-2 k', 3 psi' [rad], 4 B c^4 / l, 5 C c^2 / l [N m]

Source: Bergou et al., Discrete Elastic Rods, 2008, and Discrete Viscous Threads, 2010.
"""

from math import ceil
from typing import NamedTuple
from warnings import warn

import numpy as np

from hairpipe.data import Groom
from hairpipe.groom.binding import name_strands
from hairpipe.groom.curl_axis import curls_of
from hairpipe.groom.helix import turn_of
from hairpipe.kernels import sym3
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import load, maximum
from hairpipe.kernels.simd_arrays import difference
from hairpipe.kernels.vec3 import dot, scaled
from hairpipe.sim.layout import Layout, Shape
from hairpipe.sim.strands import lattice
from hairpipe.sim.strands.construction import Construction
from hairpipe.sim.strands.fibres import Fibre, Fibres
from hairpipe.sim.strands.forces.spring import critical_damping
from hairpipe.sim.strands.interface import ModelKind, StiffnessPart, register_model
from hairpipe.sim.strands.rest_shape import unbent
from hairpipe.sim.strands.rod.balance import balance
from hairpipe.sim.strands.rod.frames import BENDING, GHOST, TENSION, TWIST, TWISTING, frame_at
from hairpipe.sim.strands.rod.rows import (
    add_gradient,
    add_tangent,
    added_to_f,
    held_at_angles,
    in_unknowns,
    pulled_at_f,
)
from hairpipe.sim.strands.rod.semidefinite import semidefinite
from hairpipe.sim.strands.rod.twist import follow_solve, hold_tip, predict
from hairpipe.sim.strands.rod.vertex import bend, force_of, geometric, gradients, stretch_of, sum_of

SHAPE = Shape(reach=2, clamped=3, stride=1, unknowns=4, before=1, after=1)
RESTS = 6
SEGMENTS_A_TURN = 12
"""Number of segments a turn below which a curl is warned of."""
LEAST = 0.25
"""Share of the twist stiffness of a straight rod, at its tip, up to which a pivot counts as indefinite."""
TURN = 0.5
"""Turn of a frame [rad] beyond which a solve is repeated with the projected stiffness, where bending alone turns no
frame by more: the torque of bending about an edge changes its sign within a turn, whatever its derivative is."""
_PROJECTED, _EXACT = int(StiffnessPart.projected), int(StiffnessPart.exact)


class Rod(NamedTuple):
    """Constants of every strand; rows from q to q', block after block.

    first            rows of block b are first[b]:first[b+1], (blocks+1,) int64
    mass             [kg], (rows, W); 0 for q and q'
    inverse_lengths  rest values of the strand, see above, (rows, 6, W)
    constants        EA of the edge to the next row [N], (rows, 1, W)
    scale            1 / the length that scales angles [1/m], and the least stiffness of an angle [N/m], (blocks, 2, W)
    shape            shape of a strand
    """

    first: np.ndarray
    mass: np.ndarray
    inverse_lengths: np.ndarray
    constants: np.ndarray
    scale: np.ndarray
    shape = SHAPE


def build_rod(
    layout: Layout, groom: Groom, fibres: Fibres, construction: Construction, curvature: float
) -> tuple[Rod, np.ndarray]:
    """Make the rods of a groom, of round section; the construction does not affect a rod.

    curvature  share of the curvature of the groom that is at rest
    returns    the rods, and their rows in the shape of the groom [m], (rows, 3, W)
    """
    rest = layout.empty(3, dtype=np.float64)
    rod = Rod(layout.first, layout.empty(), layout.empty(RESTS), layout.empty(1), layout.empty_blocks(2))
    for blocks in layout.classes():
        places = layout.points(blocks)
        axis = groom.points[places]
        frames = groom.root_frames[layout.strands[blocks].reshape(-1)]
        fibre = fibres.of(places)
        normals = lattice.first_normals(axis, frames)
        rows, mass, natural = shape_at_rest(axis, normals, fibre)
        if curvature != 1.0:
            natural = shape_at_rest(unbent(axis, normals, curvature), normals, fibre)[2]
        layout.scatter(rows, blocks, rest)
        layout.scatter(mass, blocks, rod.mass)
        layout.scatter(natural, blocks, rod.inverse_lengths)
        axial = fibre.segments.axial[:, SHAPE.segments(axis.shape[1] - 1)]
        layout.scatter(axial[:, :, None], blocks, rod.constants)
        mean = natural[:, SHAPE.clamped - 1 : -2, 0].mean(1)
        # Of a straight rod whose tip is turned: its vertices are springs in series.
        series = 1 / np.sum(1 / natural[:, SHAPE.clamped - 1 : -2, TWISTING], axis=1)
        layout.scatter(np.stack([mean, LEAST * mean**2 * series], axis=1)[:, None], blocks, rod.scale)
    return rod, rest


def warn_of_coarse_curls(groom: Groom, fibres: Fibres) -> None:
    """Warn of curls with too few segments a turn: at 4.4 a turn they sag 14.5 % too little."""
    ends = np.stack([groom.offsets[:-1], groom.offsets[1:]], axis=1)
    turns = {k: turn_of(groom.points[slice(*ends[k])]) for k in curls_of(groom)}
    coarse = [k for k, turn in turns.items() if turn < SEGMENTS_A_TURN]
    if coarse:
        worst = min(coarse, key=lambda k: turns[k])
        needed = ceil((np.diff(ends[worst])[0] - 1) * SEGMENTS_A_TURN / turns[worst])
        message = f"{len(coarse)} of {len(groom.ids)} strands are curls of {turns[worst]:.2g} segments a turn or more"
        short = f"with fewer than {SEGMENTS_A_TURN} they are too stiff: {name_strands(groom.ids[coarse])}"
        warn(f"{message}, and {short} (segments = {needed} of the groom)", stacklevel=3)


def shape_at_rest(axis: np.ndarray, normals: np.ndarray, fibre: Fibre) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the rows of strands [m], (s, n+4, 3), their masses [kg], (s, n+4), and rest values, (s, n+4, 6).

    axis     [m], (s, n+1, 3)
    normals  unit normals of the first segments: the directors there, (s, 3)
    """
    nodes = np.concatenate([2 * axis[:, :1] - axis[:, 1:2], axis], axis=1)
    edges = np.diff(nodes, axis=1)
    lengths = np.linalg.norm(edges, axis=2)
    tangents = edges / lengths[:, :, None]
    strands = len(axis)
    count = nodes.shape[1] + 2
    natural = np.zeros((strands, count, RESTS))
    natural[:, 1:-2, 0] = 1 / lengths
    director = normals
    first = nodes[:, 0] + lengths[:, :1] * director
    for i in range(1, edges.shape[1]):
        te = tangents[:, i - 1]
        tf = tangents[:, i]
        after = lattice.transport(director, te, tf)
        twice = np.cross(te, tf) / (1 + np.sum(te * tf, axis=1, keepdims=True))
        k1 = np.sum((np.cross(te, director) + np.cross(tf, after)) * twice, axis=1)
        k2 = -np.sum((director + after) * twice, axis=1)
        flat = 1 / (1 + (k1**2 + k2**2) / 4)  # cos^2 of half the bend
        share = (lengths[:, i] + (lengths[:, i - 1] if i > 1 else 0.0)) / 2  # the clamp has nothing before it
        natural[:, i + 1, 1:3] = np.stack([k1, k2], axis=1)
        natural[:, i + 1, BENDING] = fibre.points.bending[:, i - 1] * flat**2 / share
        natural[:, i + 1, TWISTING] = fibre.points.torsion[:, i - 1] * flat / share
        director = after
    last = nodes[:, -1] + lengths[:, -1:] * director
    mass = np.zeros((strands, count))
    half = fibre.segments.line_density[:, SHAPE.segments(axis.shape[1] - 1)[1:-2]] * lengths / 2
    mass[:, 1:-2] += half
    mass[:, 2:-1] += half
    mass[:, GHOST] *= 2
    mass[:, GHOST + 1] -= half[:, 0]
    return np.concatenate([first[:, None], nodes, last[:, None]], axis=1), mass, natural


@inlined
def _springs(p: int, count: int) -> int:
    return 1 if 0 < p < count - 2 else 0


@inlined
def _constant(model, block, p, offset):
    return load(model.constants, (model.first[block] + p, 0))


@inlined
def _size(a):
    return maximum(a, -a)


@inlined
def _add_forces(model, system, at, p, block, terms):
    (A, b), (x, _, T), (h, hh, _, part) = system, at, terms
    if not 0 < p < x.shape[0] - 3:  # A vertex needs three nodes from row p on, and q and q' are not nodes.
        return
    row = model.first[block] + p + 1
    inverse = load(model.scale, (block, 0))
    bending, twisting = load(model.inverse_lengths, (row, BENDING)), load(model.inverse_lengths, (row, TWISTING))
    tangents, inverses, directors = frame_at(x, T, p)
    vertex = bend(*tangents, *inverses, *directors)
    q = (
        bending * (vertex.k1 - load(model.inverse_lengths, (row, 1))),
        bending * (vertex.k2 - load(model.inverse_lengths, (row, 2))),
        twisting * (load(T, (p + 1, TWIST)) - load(model.inverse_lengths, (row, 3))),
    )
    g1, g2, g3 = gradients(vertex)
    bent = sum_of(stretch_of(bending, g1), stretch_of(bending, g2))
    twist = stretch_of(twisting, g3)
    # Summed in (e, th_e, f, th_f) first: it is written to the matrix, which is in memory, only once.
    turning = geometric(q, vertex)
    if part == _PROJECTED:
        H = semidefinite(in_unknowns(sum_of(bent, turning), hh, inverse), x)
        s = hh * inverse * inverse / TURN
        H = held_at_angles(H, s * _size(q[0] * g1.a + q[1] * g2.a), s * _size(q[0] * g1.b + q[1] * g2.b))
        H = sum_of(H, in_unknowns(twist, hh, inverse))
    else:
        H = in_unknowns(sum_of(sum_of(bent, twist), turning), hh, inverse)
    pull, K = _edge(model, at, p + 1, row, (vertex.tf, vertex.jf), terms)
    add_gradient(b, p, h, inverse, pulled_at_f(force_of(q, (g1, g2, g3)), pull))
    add_tangent(A, p, added_to_f(H, K))


@inlined
def _edge(model, at, p, row, along, terms):
    """Pull of the edge from row p [N], and hh K + h D of it; along  its unit tangent and 1 / length."""
    (x, v, T), (t, inverse), (h, hh, damping, part) = at, along, terms
    k, inverse_rest = load(model.constants, (row, 0)), load(model.inverse_lengths, (row, 0))
    c = 0.0 * k
    if damping > 0.0:
        c = damping * critical_damping(k, inverse_rest, model.mass, row, row + 1)
    now = k * (inverse_rest * dot(difference(x, p, p + 1), t) - 1.0)
    # The tension that the last solve found: that of the present stretch would damp moving hair.
    held = now if part == _EXACT else maximum(load(T, (p, TENSION)), 0.0)
    across_it = hh * held * inverse
    xx, xy, xz, yy, yz, zz = sym3.outer(hh * k * inverse_rest + h * c - across_it, t)
    K = xx + across_it, xy, xz, yy + across_it, yz, zz + across_it
    return scaled(now + c * dot(t, difference(v, p, p + 1)), t), K


@inlined
def _largest_turn(model, block, b, h):
    most = 0.0 * h
    for p in range(GHOST, b.shape[0] - 2):
        most = maximum(most, _size(load(b, (p, 3))))
    return most * h * load(model.scale, (block, 0)) / TURN  # Unknowns are angles times a length.


@inlined
def _least_pivot(model, block, hh):
    """A share of that of a straight rod: below it one linear solve may turn a strand by revolutions."""
    return hh * load(model.scale, (block, 1))


ROD = register_model(
    ModelKind(
        "rod",
        Rod,
        SHAPE,
        build_rod,
        _add_forces,
        _springs,
        _constant,
        predict,
        hold_tip,
        follow_solve,
        _least_pivot,
        _largest_turn,
        warn=warn_of_coarse_curls,
        equilibrium=balance,
        single_limit=700.0,
    )
)
