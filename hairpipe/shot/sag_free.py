"""Rest lengths with which a groomed strand is in equilibrium under gravity.

Springs at rest in the groomed shape have no tension, so that hair sags once it is simulated. The network is isostatic
except for its altitude springs: every free particle ends three springs, as many as it has equations. Altitude springs
at rest have no force, and the tensions follow from the tip to the root, three at a time,

    sum_o T_q-o,o d_q-o,o = m_q g + sum_o T_q,o d_q,o,   o = 1, 2, 3,   d_p,o = (x_p+o - x_p) / l_p,o
    l0 = l / (1 + T / k)

which is exact. Stability and strains of the equilibrium decide whether hair can keep its shape: 10 cm of real hair can
stick out, 20 cm cannot.

Rods do the same by four stresses at a time, see `strands/rod/balance.py`.
"""

from dataclasses import dataclass
from warnings import warn

import numpy as np
from numba import njit, prange

from hairpipe.errors import BadInput
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load, maximum, sqrt, store
from hairpipe.geometry.vec3 import cross, dot, minus, scaled
from hairpipe.groom.binding import name_strands
from hairpipe.laws.settings import SagFree
from hairpipe.shot.settle import settle
from hairpipe.shot.stability import find_stable, find_stable_by_pivots
from hairpipe.strands.interface import (
    StrandModel,
    kind_of,
    may_be_lost,
    shape_of,
    spring_constant,
    springs_from,
)
from hairpipe.strands.layout import Layout

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
    rests            lanes in equilibrium, as groomed or settled, (rows, W) bool
    """

    positions: np.ndarray
    inverse_lengths: np.ndarray
    tensions: np.ndarray
    rests: np.ndarray


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
    """Find the springs, or their equivalent of a model, of strands in equilibrium at x [m], (rows, 3, W).

    gravity  [m/s^2], (3,)
    """
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
    model: StrandModel, layout: Layout, ids: np.ndarray, x: np.ndarray, gravity: np.ndarray, wanted: SagFree
) -> InitialState:
    """Find the springs of strands in equilibrium as placed; others fall, settle or are refused, with a warning.

    ids      ids of the strands, for messages
    x        particles as placed [m], (rows, 3, W)
    gravity  [m/s^2], (3,)

    Raises BadInput where the model has too few springs, or where unstable strands are refused.
    """
    if kind_of(model).equilibrium is None and model.inverse_lengths.shape[1] != SPRINGS:
        message = f"a {kind_of(model).name} has no equilibrium in a groomed shape"
        raise BadInput(message, where="model", right='"network" or "rod"')
    found = find_equilibrium(model, x, gravity)
    able = are_stable(model, x, found, wanted.strain)
    _report(able, layout, ids, wanted.unstable)
    keeps = np.repeat(able, np.diff(layout.first), axis=0)
    lengths = np.where(keeps[:, None], found.inverse_lengths, model.inverse_lengths)
    tensions = np.where(keeps[:, None], found.tensions, 0.0)
    if wanted.unstable == "fall" or able.all():
        return InitialState(x, lengths, tensions, keeps)
    settled = settle(model, layout, ids, x, gravity, ~able)
    return InitialState(
        settled.positions, lengths, np.where(keeps[:, None], tensions, settled.tensions), np.full_like(keeps, True)
    )


def _report(able: np.ndarray, layout: Layout, ids: np.ndarray, unstable: str) -> None:
    unable = ids[np.unique(layout.strands[~able])]
    if not len(unable):
        return
    message = f"{len(unable)} of {len(ids)} strands have no stable equilibrium as groomed"
    if unstable == "refuse":
        raise BadInput(
            f"{message}: {name_strands(unable)}",
            where="sag_free.unstable",
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
def _balance_block(model, block, x, gravity, T, lengths, strains):
    first = model.first[block]
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
        _balance_some(model, np.int64(block), x, gravity, T, lengths, strains)


@njit(cache=True)
def _balance_some(model, block, x, gravity, T, lengths, strains):
    rows = slice(model.first[block], model.first[block + 1])
    _balance_block(model, block, x[rows], gravity, T[rows], lengths[rows], strains)
