"""A discrete elastic rod: nodes on the axis, an angle of the material frame on every edge, four unknowns a segment.

    q  x_-1  x_0  x_1  ...  x_n  q'

Accurate, including twist, with half the segments of the network, and independent of orientation. A row has a node and
the angle of the edge to the next. x_-1 lies behind the root and forms the clamp: with a root vertex of half a length
it acts at x_0 exactly. q lies next to x_-1 and defines the director of the buried edge; q' does so next to x_n for a
held tip, and otherwise moves with it. Neither has an equation.

A vertex has B/2l c^4 |k - k'|^2 + C/2l c^2 (psi - psi')^2, see `bend_twist.py`; c = cos(phi'/2) of its natural bend
phi': 2 tan(phi/2) overestimates a coarse bend, and a curl of 8 segments per turn would be 18 % too stiff. Edges are
springs with a multiplier, as in the network.

We differ from the sources: twist has no inertia, so that its angles are not part of the motion but only of each solve,
and the state of a strand has its twists (`frames.py`). The results of a solve (see `State.T`) are in a row

    0 tension of the edge to the next node [N], 1 twist of the vertex [rad], 2-4 director of the edge, 5 twist of the
    vertex at the start of the last stage [rad]

and in the row of q, 1: repeated steps, 2: duration of the last stage [s], by which the next one predicts twists; 0: no
prediction. At rest a row has

    0 1/l' [1/m], 1-2 k', 3 psi' [rad], 4 B c^4 / l, 5 C c^2 / l [N m]

Source: Bergou et al., Discrete Elastic Rods, 2008, and Discrete Viscous Threads, 2010.

Adds vertices of a rod to the banded matrix of a strand, whose rows are `geometry/banded_angle.py`.

A vertex at row p + 1 moves nodes p, p + 1 and p + 2, and the angles of the two edges between: its edges are e = x_p+1 -
x_p and f = x_p+2 - x_p+1. Angles are multiplied by a length, so that all unknowns have similar magnitudes.

Twists of a rod's vertices, as a solve and a held tip change them; see `frames.py`.

Sag-free rods: natural bends, twists and lengths in equilibrium under weight, from the tip to the root.

A node and the angle of the edge before it have four equations, and the vertex and the edge before them four stresses:
two moments, a torque and a tension. So a strand is solved node by node:

    q1 g1_f + q2 g2_f + q3 g3_f + T tf = F,   q1 g1_b + q2 g2_b + q3 = Q

with g the derivatives of `bend_twist.py` by the edge f that ends at the node and by its angle, and F and Q the weight
and the contributions from the side of the tip. Then

    k' = k - q / B1,   psi' = psi - q3 / C1,   l' = l / (1 + T / EA)

which is exact. Stiffnesses stay those of the groom's own bends.

Takahashi and Batty, Rest Shape Optimization for Sag-Free DER, 2024, do this by an optimiser.
"""

from math import ceil
from typing import NamedTuple
from warnings import warn

import numpy as np
from numba import njit

from hairpipe.geometry import sym3
from hairpipe.geometry.banded import add
from hairpipe.geometry.banded_angle import add_point
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.curl import curls_of, turn_of
from hairpipe.geometry.frames import (
    BEFORE,
    BENDING,
    FOLDED,
    GHOST,
    SPAN,
    TENSION,
    TWIST,
    TWISTING,
    across,
    frame_at,
    transport,
    unit_of,
)
from hairpipe.geometry.simd import any_lane, difference, either, load, maximum, select, store
from hairpipe.geometry.vec3 import cross, dot, minus, plus, scaled
from hairpipe.laws.bend_twist import (
    Gradient,
    Tangent,
    bend,
    force_of,
    geometric,
    gradients,
    semidefinite,
    stretch_of,
    sum_of,
)
from hairpipe.laws.settings import Construction
from hairpipe.laws.stretch import critical_damping
from hairpipe.strands import lattice
from hairpipe.strands.interface import ModelKind, StiffnessPart, StrandModel, register_model
from hairpipe.strands.lattice import unbent
from hairpipe.strands.layout import Layout, Shape
from hairpipe.strands.material import Fibre, Fibres
from hairpipe.values import Groom
from hairpipe.values.strand_arrays import name_strands


@inlined
def in_unknowns(H, s, inverse):
    """Return s times a tangent, by angles times a length; inverse  1 / that length [1/m]."""
    ef = H.ef
    a = s * inverse
    x, y, z = scaled(s, ef[0:3]), scaled(s, ef[3:6]), scaled(s, ef[6:9])
    return Tangent(
        sym3.times(s, H.ee),
        (x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]),
        sym3.times(s, H.ff),
        scaled(a, H.e_a),
        scaled(a, H.e_b),
        scaled(a, H.f_a),
        scaled(a, H.f_b),
        a * inverse * H.aa,
        a * inverse * H.ab,
        a * inverse * H.bb,
    )


@inlined
def add_gradient(b, p, h, inverse, g: Gradient):
    """Add h times the forces of a vertex at row p + 1, the negative of its gradient, in place."""
    e, f = scaled(h, g.e), scaled(h, g.f)
    for c in range(3):
        add(b, p, c, e[c])
        add(b, p + 1, c, f[c] - e[c])
        add(b, p + 2, c, -f[c])
    add(b, p, 3, -h * inverse * g.a)
    add(b, p + 1, 3, -h * inverse * g.b)


@inlined
def _less(nine, six):
    """A block row by row less a symmetric one."""
    x = minus(nine[0:3], six[0:3])
    y = minus(nine[3:6], (six[1], six[3], six[4]))
    z = minus(nine[6:9], (six[2], six[4], six[5]))
    return x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]


@inlined
def _add_columns(A, p, column, nine):
    """Add a block row by row to the three columns of position rows from a column on, counted from the first unknown."""
    for c in range(3):
        add(A, p, column + c, nine[c])
        add(A, p, 10 + column + c, nine[3 + c])
        add(A, p, 19 + column + c, nine[6 + c])


@inlined
def _add_column(A, p, column, three):
    add(A, p, column, three[0])
    add(A, p, 10 + column, three[1])
    add(A, p, 19 + column, three[2])


@inlined
def _add_angle(A, p, column, three):
    """Add three numbers to the row of the angle of p, from a column on."""
    for c in range(3):
        add(A, p, 27 + column + c, three[c])


@inlined
def add_tangent(A, p, H: Tangent):
    """Add the tangent of a vertex at row p + 1, in place."""
    ee, ff, m = H.ee, H.ff, H.ef
    # e = x_p+1 - x_p and f = x_p+2 - x_p+1: row p gets -1 times blocks of e, row p + 1 those of e minus those of f.
    add_point(A, p, ee)
    _add_column(A, p, 3, scaled(-1.0, H.e_a))
    _add_columns(A, p, 4, _less(m, ee))
    _add_column(A, p, 7, scaled(-1.0, H.e_b))
    _add_columns(A, p, 8, (-m[0], -m[1], -m[2], -m[3], -m[4], -m[5], -m[6], -m[7], -m[8]))
    add(A, p, 30, H.aa)
    _add_angle(A, p, 4, minus(H.e_a, H.f_a))
    add(A, p, 34, H.ab)
    _add_angle(A, p, 8, H.f_a)
    both = m[0] + m[0], m[1] + m[3], m[2] + m[6], m[4] + m[4], m[5] + m[7], m[8] + m[8]
    add_point(A, p + 1, sym3.minus(sym3.plus(ee, ff), both))
    _add_column(A, p + 1, 3, minus(H.e_b, H.f_b))
    _add_columns(A, p + 1, 4, _less(m, ff))
    add(A, p + 1, 30, H.bb)
    _add_angle(A, p + 1, 4, H.f_b)
    add_point(A, p + 2, ff)


@inlined
def added_to_f(H, six):
    """Return a tangent with a symmetric block more by f."""
    return Tangent(H.ee, H.ef, sym3.plus(H.ff, six), H.e_a, H.e_b, H.f_a, H.f_b, H.aa, H.ab, H.bb)


@inlined
def held_at_angles(H, a, b):
    """Return a tangent with so much more on the diagonal of both angles."""
    return Tangent(H.ee, H.ef, H.ff, H.e_a, H.e_b, H.f_a, H.f_b, H.aa + a, H.ab, H.bb + b)


@inlined
def pulled_at_f(g, force):
    """Return a gradient with so much more by f."""
    return Gradient(g.e, plus(g.f, force), g.a, g.b)


_SHORTEST = 1e-30


@inlined
def predict(model, T, span, stays):
    """Extrapolate twists at the rate of the last stage, except in lanes where they are fixed, in place.

    A solve linearised at the initial twists of its stage is of first order.
    """
    last = load(T, (0, SPAN))
    goes = select(either(stays, last <= 0.0), 0.0, span / maximum(last, _SHORTEST))
    for p in range(GHOST + 1, T.shape[0] - 2):
        twist = load(T, (p, TWIST))
        store(T, (p, TWIST), twist + goes * (twist - load(T, (p, BEFORE))))
        store(T, (p, BEFORE), twist)  # The rate of this stage, by which the next one predicts.
    store(T, (0, SPAN), 0.0 * last + span)


@inlined
def follow_solve(model, block, at, dx, b, h):
    """Change twists by the rotation of edges in a solve, to first order, in place: the next solve is linearised there.

    dpsi = kb/2 . (de/|e| + df/|f|) + dth_f - dth_e
    """
    x, T = at.x, at.T
    s = h * load(model.scale, (block, 0))  # Unknowns are angles times a length.
    for p in range(GHOST, x.shape[0] - 3):
        te, ie = unit_of(difference(x, p, p + 1))
        tf, jf = unit_of(difference(x, p + 1, p + 2))
        over = plus(scaled(ie, difference(dx, p, p + 1)), scaled(jf, difference(dx, p + 1, p + 2)))
        writhed = dot(cross(te, tf), over) / maximum(1.0 + dot(te, tf), FOLDED)
        turned = s * (load(b, (p + 1, 3)) - load(b, (p, 3)))
        store(T, (p + 1, TWIST), load(T, (p + 1, TWIST)) + (writhed + turned))


@njit(cache=True, error_model="numpy")
def hold_tip(model, block, x, T, held):
    """Set the remaining twist of the last vertex where the tip is held, in place."""
    if len(held) > 0:
        fixed = load(held, (block,)) > 0.0
        if any_lane(fixed):
            _hold_tip(x, T, fixed)


@njit(cache=True, error_model="numpy")
def _hold_tip(x, T, fixed):
    """Compare the last director with what q' shows; the nearest of the twists that differ by turns is taken."""
    last = x.shape[0] - 3
    (te, tf), _, (m, _) = frame_at(x, T, GHOST)
    for p in range(GHOST + 1, last):  # The tip's director depends on all twists: frames are carried from the root.
        (te, tf), _, (m, _) = frame_at(x, T, p)
    over = transport(m, te, tf)
    shown = across(difference(x, last + 1, last + 2), tf)
    rows = np.empty((2, x.shape[2]), x.dtype)
    store(rows, (0,), dot(cross(over, shown), tf))
    store(rows, (1,), dot(over, shown))
    for lane in range(x.shape[2]):  # Lane by lane: arctan2 has no vector form here, and is needed once a strand only.
        before = T[last, TWIST, lane]
        change = np.arctan2(rows[0, lane], rows[1, lane]) - before
        rows[0, lane] = before + change - 2.0 * np.pi * np.round(change / (2.0 * np.pi))
    store(T, (last, TWIST), select(fixed, load(rows, (0,)), load(T, (last, TWIST))))


def balance(model: StrandModel, x: np.ndarray, gravity: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the rest state of rods in equilibrium without twist at x [m], (rows, 3, W), under gravity [m/s^2], (3,)."""
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


def _directors(x: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    """Directors of all edges from the buried one on, without twist, (s, n+1, 3)."""
    shown = x[:, 0] - x[:, GHOST]
    across = shown - _dot(shown, tangents[:, 0]) * tangents[:, 0]
    found = [across / np.linalg.norm(across, axis=-1, keepdims=True)]
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
    layout: Layout, groom: Groom, fibres: Fibres, construction: Construction, shape: float | np.ndarray
) -> tuple[Rod, np.ndarray]:
    """Make the rods of a groom, of round section; the construction does not affect a rod."""
    rest = layout.empty(3, dtype=np.float64)
    rod = Rod(layout.first, layout.empty(), layout.empty(RESTS), layout.empty(1), layout.empty_blocks(2))
    for blocks in layout.classes():
        places = layout.points(blocks)
        axis = groom.points[places]
        frames = groom.root_frames[layout.strands[blocks].reshape(-1)]
        fibre = fibres.of(places)
        normals = lattice.first_normals(axis, frames)
        rows, mass, natural = shape_at_rest(axis, normals, fibre)
        shares = np.broadcast_to(shape, len(groom.points))[places]
        if (shares != 1.0).any():
            natural = shape_at_rest(unbent(axis, normals, shares), normals, fibre)[2]
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
def _springs(model, p, count):
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
