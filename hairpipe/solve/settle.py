"""Strands brought to rest under gravity, quasi-statically, by large damped steps.

From x, always at rest, a step of backward Euler, linearised as any stage:

    (M / h^2 + K) dx = f(x) + M g,   x += dx

For large h it is Newton's method, with a K that is never indefinite, so that the energy falls. h grows as the residual
forces fall and shrinks as they rise, and no particle moves by more than half a segment along an axis in a step. Every
strand has its own h and its own end, so that strands are independent.

Source: Kelley and Keyes, Convergence Analysis of Pseudo-Transient Continuation, 1998.

A groom at rest under gravity.
"""

from dataclasses import dataclass, replace
from warnings import warn

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import any_lane, load, maximum, minimum, select, store
from hairpipe.laws.settings import Construction
from hairpipe.solve.band import add_inertia, eliminate, fix_root, row_size, start_row, substitute
from hairpipe.solve.stage import Iterate
from hairpipe.solve.stretch import set_tensions
from hairpipe.strands.hair_model import build_models
from hairpipe.strands.interface import StiffnessPart, StrandModel, Terms, add_forces, follow_solve, shape_of
from hairpipe.strands.layout import Layout
from hairpipe.strands.material import VariedMaterial
from hairpipe.strands.registry import ModelName
from hairpipe.values import Groom
from hairpipe.values.painting import ReadImage, Varied
from hairpipe.values.strand_arrays import name_strands

STILL = 1e-7
"""Residual force on a particle along an axis, over the mass of its strand, at rest [m/s^2]: 1e-8 of its weight."""
_MOST_STEPS = 2000
_FULL, _PROJECTED = int(StiffnessPart.full), int(StiffnessPart.projected)
_START = 24.0
"""1 / h of the first step [1/s]."""
_FURTHEST = 0.5
"""Largest displacement of a particle along an axis in a step, over the length of a segment."""


@dataclass(frozen=True, eq=False)
class Settled:
    """Strands at rest.

    positions  [m], (rows, 3, W)
    tensions   of their springs [N], (rows, springs, W)
    left       largest component of a residual force, over the mass of a strand [m/s^2], (blocks, W)
    """

    positions: np.ndarray
    tensions: np.ndarray
    left: np.ndarray


def settle(
    model: StrandModel, layout: Layout, ids: np.ndarray, x: np.ndarray, gravity: np.ndarray, active: np.ndarray
) -> Settled:
    """Bring strands to rest under gravity; a warning names those that do not come to rest. Pure.

    ids      of the strands
    x        particles as they start [m], (rows, 3, W)
    gravity  [m/s^2], (3,)
    active   strands to settle; the others are unchanged, (blocks, W) bool
    """
    positions = x.copy()
    tensions = np.zeros_like(model.inverse_lengths)
    left = np.zeros(active.shape)
    settle_all(model, positions, tensions, gravity, active.astype(float), left)
    moving = ids[np.unique(layout.strands[~(left <= STILL)])]
    if len(moving):
        warn(f"{len(moving)} of {len(ids)} strands have not come to rest: {name_strands(moving)}", stacklevel=3)
    return Settled(positions, tensions, left)


@njit(cache=True, parallel=True)
def settle_all(model, x, T, gravity, active, left):
    """Bring active strands, (blocks, W), to rest, in place; arguments as in `Settled`."""
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _settle(model, np.int64(block), x, T, gravity, active, left)


@inlined
def _assemble(model, block, A, b, at, gravity, part):
    """Set A to the stiffness of a block and b to the forces on its particles; return the largest on a free one."""
    count = at.x.shape[0]
    for p in range(count):
        start_row(model, A, p, count)
        m = load(model.mass, (model.first[block] + p,))
        for c in range(3):
            store(b, (p, c), gravity[c] * m)
        for c in range(3, b.shape[1]):
            store(b, (p, c), 0.0)
    for p in range(count):
        add_forces(model, (A, b), at, p, block, Terms(1.0, 1.0, 0.0, part))
    return _largest(b, shape_of(model).clamped)


@inlined
def solve(model, block, A, b, rate):
    """Replace b by the displacement of a block; return the lowest pivot, where it may be negative.

    rate  1 / h^2 [1/s^2], in lanes
    """
    count = b.shape[0]
    one = 0.0 * load(b, (0, 0)) + 1.0
    lowest = one, one
    for p in range(count):
        if p < shape_of(model).clamped:
            lowest = fix_root(model, A, b, p, count, lowest)
        else:
            add_inertia(model, A, p, rate * load(model.mass, (model.first[block] + p,)))
            lowest = eliminate(model, A, b, p, count, lowest)
    substitute(model, A, b, count)
    return minimum(lowest[0], lowest[1])


@inlined
def _largest(b, first):
    """Return the largest component from a particle on; NaN if any is NaN."""
    largest = nothing = 0.0 * load(b, (first, 0))
    for p in range(first, b.shape[0]):
        for c in range(b.shape[1]):
            size = load(b, (p, c))
            largest = maximum(largest, maximum(size, -size))
            nothing = nothing + 0.0 * size  # unless it is not finite
    return largest + nothing


@njit(cache=True, error_model="numpy")
def _settle(model, block, positions, tensions, gravity, active, left):
    rows = slice(model.first[block], model.first[block + 1])
    x = positions[rows]
    T = tensions[rows]
    count = x.shape[0]
    clamped = shape_of(model).clamped
    stride = shape_of(model).stride
    A = np.empty((count, row_size(shape_of(model)), x.shape[2]), x.dtype)
    b = np.empty((count, shape_of(model).unknowns, x.shape[2]), x.dtype)
    dx = np.zeros_like(x)
    at = Iterate(x, np.zeros_like(x), T)
    mass = 0.0 * load(x, (0, 0))
    for p in range(clamped, count):
        mass = mass + load(model.mass, (model.first[block] + p,))
    furthest = _FURTHEST / load(model.inverse_lengths, (model.first[block] + shape_of(model).before, stride - 1))
    rate = mass * 0.0 + _START * _START
    before = mass * 0.0
    for step in range(_MOST_STEPS + 1):  # All lanes of a block, until the last is at rest; the others do not move.
        set_tensions(model, block, x, T)
        force = _assemble(model, block, A, b, at, gravity, _FULL) / mass
        moving = select(load(active, (block,)) > 0.0, force, 0.0)
        store(left, (block,), moving)
        if step == _MOST_STEPS or not any_lane(moving > STILL):
            break
        if step > 0:
            rate = rate * minimum(maximum(force / before, 0.5), 2.0)  # h grows as forces fall.
        before = force
        lowest = solve(model, block, A, b, rate)
        if any_lane(lowest <= 0.0):
            _assemble(model, block, A, b, at, gravity, _PROJECTED)
            solve(model, block, A, b, rate)
        way = _largest(b, clamped)
        part = select(moving > STILL, select(way > furthest, furthest / way, 1.0), 0.0)
        for p in range(clamped - 1, count):  # From the root's own row on: a rod has a free angle there.
            for c in range(b.shape[1]):
                store(b, (p, c), part * load(b, (p, c)))
        for p in range(clamped, count):
            for c in range(3):
                store(dx, (p, c), load(b, (p, c)))
        follow_solve(model, block, at, dx, b, 1.0)
        for p in range(clamped, count):
            for c in range(3):
                store(x, (p, c), load(x, (p, c)) + load(dx, (p, c)))


def settle_groom(
    groom: Groom,
    material: VariedMaterial,
    construction: Construction,
    gravity: float,
    model: ModelName,
    read_image: ReadImage | None = None,
    shape: Varied | float = 1.0,
) -> Groom:
    """Return the groom with its strands at rest under gravity, with springs at rest as groomed, or straighter.

    gravity  along -Y [m/s^2]
    model    of a strand
    shape    share of the curvature of the groom at rest

    A warning names strands that do not come to rest. Raise BadInput where the body holds tips.
    """
    if groom.tip_triangles is not None:
        raise BadInput("tips held by the body would be released", where="in.groom", right="a groom of free tips")
    hair = build_models(groom, material, model, construction, read_image, shape).in_precision("double")
    everyone = np.ones(hair.layout.strands.shape, bool)
    down = np.array([0.0, -gravity, 0.0])
    settled = settle(hair.model, hair.layout, groom.ids, hair.rest, down, everyone)
    return replace(groom, points=hair.layout.axis(settled.positions))
