"""Rest lengths with which a groomed strand is in equilibrium under gravity.

Springs at rest in the groomed shape have no tension, so that hair sags once it is simulated. The network is isostatic
except for its altitude springs: every free particle ends three springs, as many as it has equations. Altitude springs
at rest have no force, and the tensions follow from the tip to the root, three at a time,

    sum_o T_q-o,o d_q-o,o = m_q g + sum_o T_q,o d_q,o,   o = 1, 2, 3,   d_p,o = (x_p+o - x_p) / l_p,o
    l0 = l / (1 + T / k)

which is exact. Stability and strains of the equilibrium decide whether hair can keep its shape: 10 cm of real hair can
stick out, 20 cm cannot.

Rods do the same by four stresses at a time, see `strands/rod.py`.

Stability of a strand: the exact second derivatives of its energy, banded.

The matrix of a step omits the indefinite terms, which decide on stability: the forces of the kernels are differentiated
numerically. Particles farther apart than twice the reach of a force are moved at once: 2 reach + 1 colours, each in
three directions, are all columns.

A model whose matrix may be indefinite has exact second derivatives: their pivots are tested.

At an exchange of altitude springs forces have a kink, or a jump unless they are at rest: the step of a difference must
not reach it.
"""

from dataclasses import dataclass
from warnings import warn

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.banded import add
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import fill, load, maximum, select, sqrt, store
from hairpipe.geometry.vec3 import cross, dot, minus, scaled
from hairpipe.laws.settings import Rest
from hairpipe.solve.band import row_size, start_row
from hairpipe.solve.settle import settle, solve
from hairpipe.solve.stage import Iterate, System
from hairpipe.strands.interface import (
    StiffnessPart,
    StrandModel,
    Terms,
    add_forces,
    kind_of,
    may_be_lost,
    shape_of,
    spring_constant,
    springs_from,
)
from hairpipe.strands.layout import Layout
from hairpipe.values.strand_arrays import name_strands

_EXACT = int(StiffnessPart.exact)
_WEIGHTS = np.array([3 / 4, -3 / 20, 1 / 60])
"""Central differences of sixth order."""


@njit(cache=True)
def _set_forces(model, block, A, b, x, still, slack):
    """Set b to the forces of a block's springs; still and slack are zero, and nothing but zeros is added to A."""
    fill(b, 0.0)
    for p in range(x.shape[0]):
        add_forces(model, System(A, b), Iterate(x, still, slack), p, block, Terms(1.0, 0.0, 0.0, 0))


@inlined
def _add_column(H, slope, p, c, reach):
    """Add the decrease of forces as particle p moves along c, half to each of the two places of an entry."""
    i = 3 * p + c
    for j in range(3 * max(0, p - reach), 3 * min(slope.shape[0], p + reach + 1)):
        half = -0.5 * load(slope, (j // 3, j % 3))
        add(H, min(i, j), abs(i - j), half + half if i == j else half)


@njit(cache=True)
def tangent(model, block, x, steps) -> np.ndarray:
    """Differentiate the energy of a block twice [N/m], (3 particles, 3 reach + 3, W): H[i, k] couples i and i + k.

    x      positions [m], (particles, 3, W)
    steps  of the differences for all strands [m], (blocks, W)
    """
    count = x.shape[0]
    reach = shape_of(model).reach
    H = np.zeros((3 * count, 3 * reach + 3, x.shape[2]), x.dtype)
    A = np.zeros((count, row_size(shape_of(model)), x.shape[2]), x.dtype)
    still, slack = np.zeros_like(x), np.zeros_like(x)
    moved = x.copy()
    slope = np.empty_like(x)
    b = np.empty_like(x)
    step = load(steps, (block,))
    for colour in range(2 * reach + 1):  # Particles of a colour have no force in common, and are moved at once.
        for c in range(3):
            fill(slope, 0.0)
            for side in range(6):
                sign = 1.0 - 2.0 * (side % 2)
                far = side // 2 + 1
                for p in range(colour, count, 2 * reach + 1):
                    store(moved, (p, c), load(x, (p, c)) + sign * far * step)
                _set_forces(model, block, A, b, moved, still, slack)
                weight = sign * _WEIGHTS[far - 1] / step
                for p in range(count):
                    for d in range(3):
                        store(slope, (p, d), load(slope, (p, d)) + weight * load(b, (p, d)))
            for p in range(colour, count, 2 * reach + 1):
                store(moved, (p, c), load(x, (p, c)))
                _add_column(H, slope, p, c, reach)
    return H


@njit(cache=True, parallel=True)
def find_stable(model, x, steps, stable) -> None:
    """Set stable to 1 where a strand is stiff against every motion of its free particles, else to 0, in place."""
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _find_stable(model, np.int64(block), x, steps, stable)


@njit(cache=True, error_model="numpy")
def _find_stable(model, block, x, steps, stable):
    """Eliminate all unknowns: H is positive definite where all pivots are positive."""
    rows = x[model.first[block] : model.first[block + 1]]
    clamped = shape_of(model).clamped
    H = tangent(model, block, rows, steps)
    store(stable, (block,), 1.0)
    for i in range(3 * clamped, H.shape[0]):
        pivot = load(H, (i, 0))
        store(stable, (block,), select(pivot > 0.0, load(stable, (block,)), 0.0))  # False for NaN, too.
        for k in range(1, min(H.shape[1], H.shape[0] - i)):
            part = load(H, (i, k)) / pivot
            for m in range(k, min(H.shape[1], H.shape[0] - i)):
                store(H, (i + k, m - k), load(H, (i + k, m - k)) - part * load(H, (i, m)))


@njit(cache=True)
def assemble(model, block, x, T, part):
    """Return the matrix of a block without inertia, banded as in `band.py`, and its forces, (rows, unknowns, W).

    x, T  positions [m], and stored values of the model
    part  of the stiffness, a StiffnessPart
    """
    count = x.shape[0]
    A = np.empty((count, row_size(shape_of(model)), x.shape[2]), x.dtype)
    b = np.zeros((count, shape_of(model).unknowns, x.shape[2]), x.dtype)
    still = np.zeros_like(x)
    for p in range(count):
        start_row(model, A, p, count)
    for p in range(count):  # A second pass: forces of a row are added to cleared rows after it.
        add_forces(model, System(A, b), Iterate(x, still, T), p, block, Terms(1.0, 1.0, 0.0, part))
    return A, b


@njit(cache=True, parallel=True)
def find_stable_by_pivots(model, x, T, stable) -> None:
    """Set stable to 1 where every pivot of a strand's own second derivatives is positive, else to 0, in place."""
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _find_stable_by_pivots(model, np.int64(block), x, T, stable)


@njit(cache=True, error_model="numpy")
def _find_stable_by_pivots(model, block, x, T, stable):
    rows = slice(model.first[block], model.first[block + 1])
    A, b = assemble(model, block, x[rows], T[rows].copy(), _EXACT)
    nothing = 0.0 * load(stable, (block,))
    store(stable, (block,), select(solve(model, block, A, b, nothing) > 0.0, nothing + 1.0, 0.0))


SPRINGS = 3
"""Number of springs that end at a free particle: as many as it has equations."""
STEP = 1e-5
"""Step of differences of forces, over the length of a segment: curls can be close to an exchange of springs."""


@dataclass(frozen=True, eq=False)
class InitialState:
    """Initial state of strands.

    positions        [m], (rows, 3, W)
    inverse_lengths  1 / l0 of their springs [1/m], (rows, springs, W)
    tensions         of their springs [N], same shape
    sags             share of the weight that is not balanced: 0 in equilibrium, as groomed or settled, (rows, W)
    """

    positions: np.ndarray
    inverse_lengths: np.ndarray
    tensions: np.ndarray
    sags: np.ndarray


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Springs of strands in equilibrium.

    inverse_lengths  1 / l0 [1/m], (rows, springs, W)
    tensions         [N], same shape
    strains          the largest of a strand, l / l0 - 1 or its opposite, (blocks, W)
    """

    inverse_lengths: np.ndarray
    tensions: np.ndarray
    strains: np.ndarray


def find_equilibrium(model: StrandModel, x: np.ndarray, gravity: np.ndarray) -> Equilibrium:
    """Find the springs, or their equivalent of a model, of strands in equilibrium at x [m], (rows, 3, W)."""
    equilibrium = kind_of(model).equilibrium
    if equilibrium is not None:
        return Equilibrium(*equilibrium(model, x, gravity))
    lengths, tensions = np.zeros_like(model.inverse_lengths), np.zeros_like(model.inverse_lengths)
    strains = np.zeros((len(model.first) - 1, x.shape[2]))
    _balance_all(model, x, gravity, tensions, lengths, strains)
    return Equilibrium(lengths, tensions, strains)


def are_stable(model: StrandModel, x: np.ndarray, found: Equilibrium, limit: float) -> np.ndarray:
    """Return which strands are stable at x [m] with the found springs, within the strain limit, (blocks, W) bool."""
    model = model._replace(inverse_lengths=found.inverse_lengths)
    stable = np.zeros_like(found.strains)
    if may_be_lost(model):
        find_stable_by_pivots(model, x, found.tensions, stable)
    else:
        edges = np.linalg.norm(x[model.first[:-1] + 2] - x[model.first[:-1]], axis=1)
        find_stable(model, x, STEP * edges, stable)
    return (stable > 0.0) & (found.strains <= limit)


def find_initial_state(
    model: StrandModel,
    layout: Layout,
    ids: np.ndarray,
    x: np.ndarray,
    gravity: np.ndarray,
    wanted: Rest,
    shares: np.ndarray,
) -> InitialState:
    """Find the springs of strands that bear a share of their weight as placed, and where strands settle.

    Springs are linear in the share s: 1 / l0 = (1 - s) / l0(rest) + s / l0(equilibrium), as tensions are linear in
    gravity; so are the natural curvature and twist of a rod. Strands without a stable equilibrium fall, settle or are
    refused, with a warning.

    ids      ids of the strands, for messages
    x        particles as placed [m], (rows, 3, W)
    gravity  [m/s^2], (3,)
    shares   of their weight that strands bear, (blocks, W)

    Raises BadInput where the model has too few springs, or where unstable strands are refused.
    """
    asked = shares > 0.0
    able = np.zeros_like(asked)
    lengths = model.inverse_lengths
    tensions = np.zeros_like(lengths)
    rows = np.diff(layout.first)
    if asked.any():
        found = partly(find_balance(model, x, gravity), model, shares, rows)
        able = asked & are_stable(model, x, found, wanted.strain)
        _report(asked & ~able, layout, ids, wanted.unstable)
        keeps = np.repeat(able, rows, axis=0)[:, None]
        lengths = np.where(keeps, found.inverse_lengths, lengths)
        tensions = np.where(keeps, found.tensions, 0.0)
    sags = np.where(able, 1.0 - shares, 1.0)
    settling = sags > 0.0 if wanted.start == "settled" else asked & ~able & (wanted.unstable == "settle")
    if settling.any():
        own = model._replace(inverse_lengths=lengths)
        settled = settle(own, layout, ids, x, gravity, settling)
        x = settled.positions
        tensions = np.where(np.repeat(settling, rows, axis=0)[:, None], settled.tensions, tensions)
    return InitialState(x, lengths, tensions, np.repeat(np.where(settling, 0.0, sags), rows, axis=0))


def find_balance(model: StrandModel, x: np.ndarray, gravity: np.ndarray) -> Equilibrium:
    """Find the equilibrium of strands as placed; BadInput where the model has too few springs for it."""
    if kind_of(model).equilibrium is None and model.inverse_lengths.shape[1] != SPRINGS:
        message = f"a {kind_of(model).name} has no equilibrium in a groomed shape"
        raise BadInput(message, where="model", right='"network" or "rod"')
    return find_equilibrium(model, x, gravity)


def partly(found: Equilibrium, model: StrandModel, shares: np.ndarray, rows: np.ndarray) -> Equilibrium:
    """Return springs in equilibrium with a share of the weight of strands, (blocks, W); rows of blocks, (blocks,)."""
    share = np.repeat(shares, rows, axis=0)[:, None]
    lengths = (1.0 - share) * model.inverse_lengths + share * found.inverse_lengths
    return Equilibrium(lengths, share * found.tensions, shares * found.strains)


def _report(lost: np.ndarray, layout: Layout, ids: np.ndarray, unstable: str) -> None:
    unable = ids[np.unique(layout.strands[lost])]
    if not len(unable):
        return
    message = f"{len(unable)} of {len(ids)} strands have no stable equilibrium as groomed"
    if unstable == "refuse":
        raise BadInput(
            f"{message}: {name_strands(unable)}",
            where="rest.unstable",
            right='shorter or stiffer hair, or "fall" or "settle"',
        )
    warn(f"{message} and {unstable}: {name_strands(unable)}", stacklevel=3)


@inlined
def _direction(x, p, q):
    """Unit vector from particle p to q, and the inverse of its length [1/m]."""
    span = minus(
        (load(x, (q, 0)), load(x, (q, 1)), load(x, (q, 2))), (load(x, (p, 0)), load(x, (p, 1)), load(x, (p, 2)))
    )
    inverse = 1.0 / sqrt(dot(span, span))
    return scaled(inverse, span), inverse


@inlined
def _solve_tensions(x, b, T, q):
    """Find the three tensions that balance b_q [N], and add their forces to the particles before q, in place."""
    d1, d2, d3 = _direction(x, q - 1, q)[0], _direction(x, q - 2, q)[0], _direction(x, q - 3, q)[0]
    f = load(b, (q, 0)), load(b, (q, 1)), load(b, (q, 2))
    n1, n2, n3 = cross(d2, d3), cross(d3, d1), cross(d1, d2)
    inverse = 1.0 / dot(d1, n1)
    for o, d, n in ((1, d1, n1), (2, d2, n2), (3, d3, n3)):
        t = inverse * dot(n, f)
        store(T, (q - o, o - 1), t)
        for c in range(3):
            store(b, (q - o, c), load(b, (q - o, c)) + t * d[c])


@njit(cache=True, error_model="numpy")
def _balance_block(model, block, positions, gravity, tensions, inverse_lengths, strains):
    first = model.first[block]
    rows = slice(first, model.first[block + 1])
    x = positions[rows]
    T = tensions[rows]
    lengths = inverse_lengths[rows]
    count = x.shape[0]
    b = np.empty_like(x)
    for p in range(count):
        for c in range(3):
            store(b, (p, c), gravity[c] * load(model.mass, (first + p,)))
    for q in range(count - 1, shape_of(model).clamped - 1, -1):  # From the tip: the load adds up towards the root.
        _solve_tensions(x, b, T, q)
    worst = nothing = 0.0 * load(x, (0, 0))
    for p in range(count):
        for o in range(1, springs_from(model, p, count) + 1):
            strain = load(T, (p, o - 1)) / spring_constant(model, block, p, o)
            store(lengths, (p, o - 1), (1.0 + strain) * _direction(x, p, p + o)[1])
            worst = maximum(worst, maximum(strain, -strain))
            nothing = nothing + 0.0 * strain  # unless it is not finite
    store(strains, (block,), worst + nothing)


@njit(cache=True, parallel=True)
def _balance_all(model, x, gravity, T, lengths, strains):
    """Fill tensions, inverse rest lengths and strains of all strands, in place."""
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _balance_block(model, np.int64(block), x, gravity, T, lengths, strains)
