"""One linearly implicit stage of a time integrator: assemble, eliminate and substitute, fused per block of strands.

A stage asks for the velocity v at its end, with x = xh + h v, such that M (v - vh) = h f(x, v). Linearised once at a
guess,

    (M + h D + h^2 K) dv = M (vh - v) + h (f(x) - D v),   v += dv,  x += h dv.

Every integrator is a sequence of such stages; they differ in h, xh, vh and the guess.
"""

import numpy as np
from numba import njit

from hairpipe.sim.banded import ROW, add, clear_row, eliminate, fix_row, substitute
from hairpipe.sim.forces.altitude import add_altitude
from hairpipe.sim.forces.spring import add_spring, multiplier
from hairpipe.sim.lanes import any_lane, either, load, select, sqrt, store
from hairpipe.sim.lattice import CLAMPED
from hairpipe.sim.network import Network

_STRAIN_GUARD = 0.03  # an edge strained by more than this at the guess sends its strand back to the stage before


@njit(cache=True)
def _constant(constants, block, p, offset):  # noqa: ANN001, ANN202
    """Constant of the spring from particle p to p + offset: edge, bending or torsion, see the lattice."""
    if offset == 3:
        return _at_root(p) * load(constants, (block, 2))
    if offset == 2 and p % 2:
        return _at_root(p) * load(constants, (block, 1))
    return load(constants, (block, 0))


@njit(cache=True)
def _at_root(p: int) -> float:
    """Stiffness across m_0, half of whose joint is buried."""
    return 2.0 if p < 2 else 1.0


@njit(cache=True)
def _start_row(A, b, mass, vh, v, p, h, gravity, drag):  # noqa: ANN001, ANN202
    """Inertia, weight and air drag of particle p."""
    clear_row(A, p)
    m = load(mass, (p,))
    for c in range(3):
        speed = load(v, (p, c))
        store(b, (p, c), m * (load(vh, (p, c)) - speed + h * (gravity[c] - drag * speed)))
    inertia = m * (1.0 + h * drag)
    add(A, p, 0, inertia)
    add(A, p, 3, inertia)
    add(A, p, 5, inertia)


@njit(cache=True)
def _solve(A, b, x, v, vh, T, mass, inverse_lengths, inverse_heights, constants, block, h, gravity, drag):  # noqa: ANN001, ANN202
    """Leave the change of velocity in b [m/s]."""
    count = x.shape[0]
    for p in range(min(3, count)):
        _start_row(A, b, mass, vh, v, p, h, gravity, drag)
    altitude = load(constants, (block, 3))
    for p in range(count):
        if p + 3 < count:
            _start_row(A, b, mass, vh, v, p + 3, h, gravity, drag)
            add_altitude(A, b, x, p, _at_root(p) * altitude, inverse_heights, h)
        for o in range(1, min(3, count - 1 - p) + 1):
            k = _constant(constants, block, p, o)
            add_spring(A, b, x, T, p, o, k, load(inverse_lengths, (p, o - 1)), h)
        if p < CLAMPED:
            fix_row(A, b, p)
        else:
            eliminate(A, b, p, count)
    substitute(A, b, count)


@njit(cache=True)
def _update(x, v, T, dx, b, bad, only_bad, inverse_lengths, constants, block, h):  # noqa: ANN001, ANN202
    """Move to the solution; with only_bad, in the flagged lanes only."""
    count = x.shape[0]
    for p in range(count):
        for c in range(3):
            dv = load(b, (p, c))
            if only_bad:
                dv = select(bad, dv, 0.0 * dv)
            store(dx, (p, c), h * dv)
            store(v, (p, c), load(v, (p, c)) + dv)
    for p in range(count):
        for o in range(1, min(3, count - 1 - p) + 1):
            t = multiplier(x, dx, p, o, _constant(constants, block, p, o), load(inverse_lengths, (p, o - 1)))
            if only_bad:
                t = select(bad, t, load(T, (p, o - 1)))
            store(T, (p, o - 1), t)
    for p in range(count):
        for c in range(3):
            store(x, (p, c), load(x, (p, c)) + load(dx, (p, c)))


@njit(cache=True)
def overstrained(x, inverse_lengths, limit):  # noqa: ANN001, ANN201
    """Lanes with an axis edge whose strain is beyond +-limit."""
    worst = load(x, (0, 0)) < load(x, (0, 0))
    for p in range(0, x.shape[0] - 2, 2):
        dx = load(x, (p + 2, 0)) - load(x, (p, 0))
        dy = load(x, (p + 2, 1)) - load(x, (p, 1))
        dz = load(x, (p + 2, 2)) - load(x, (p, 2))
        strain = sqrt(dx * dx + dy * dy + dz * dz) * load(inverse_lengths, (p, 1)) - 1.0
        worst = either(worst, either(strain > limit, strain < -limit))
    return worst


@njit(cache=True)
def set_tensions(network: Network, block: int, x: np.ndarray, T: np.ndarray) -> None:
    """Set the multipliers of a block to the tensions of its present stretch [N], in place.

    x, T  (particles, 3, WIDTH)
    """
    lengths = network.inverse_lengths[network.first[block] : network.first[block + 1]]
    still = np.zeros_like(x)
    for p in range(x.shape[0]):
        for o in range(1, min(3, x.shape[0] - 1 - p) + 1):
            k = _constant(network.constants, block, p, o)
            store(T, (p, o - 1), multiplier(x, still, p, o, k, load(lengths, (p, o - 1))))


@njit(cache=True)
def run_stage(
    network: Network,
    block: int,
    x: np.ndarray,
    v: np.ndarray,
    T: np.ndarray,
    xh: np.ndarray,
    vh: np.ndarray,
    before: np.ndarray,
    clamped: np.ndarray,
    h: float,
    gravity: np.ndarray,
    drag: float,
) -> None:
    """Advance one block of strands through a stage, in place.

    x, v     out: positions [m] and velocities [m/s] at the end, (particles, 3, WIDTH); in: v is the guess
    T        multipliers of the springs [N], in: of the solve before, (particles, 3, WIDTH)
    xh, vh   explicit parts of position and velocity
    before   positions at the start of the stage, where a strand restarts if the guess strains it too much
    clamped  positions of the clamped particles at the end [m], (CLAMPED, 3, WIDTH)
    h        weight of the end [s]; gravity [m/s^2], (3,); drag  against still air [1/s]
    """
    first, last = network.first[block], network.first[block + 1]
    count = last - first
    lengths = network.inverse_lengths[first:last]
    heights = network.inverse_heights[first:last]
    mass = network.mass[first:last]
    A = np.empty((count, ROW, x.shape[2]))
    b = np.empty_like(x)
    dx = np.empty_like(x)
    for p in range(count):
        for c in range(3):
            if p < CLAMPED:
                store(x, (p, c), load(clamped, (p, c)))
                store(v, (p, c), (load(clamped, (p, c)) - load(xh, (p, c))) / h)
            else:
                store(x, (p, c), load(xh, (p, c)) + h * load(v, (p, c)))
    bad = overstrained(x, lengths, _STRAIN_GUARD)
    restart = any_lane(bad)
    if restart:
        for p in range(CLAMPED, count):
            for c in range(3):
                store(x, (p, c), select(bad, load(before, (p, c)), load(x, (p, c))))
                store(v, (p, c), select(bad, (load(x, (p, c)) - load(xh, (p, c))) / h, load(v, (p, c))))
    _solve(A, b, x, v, vh, T, mass, lengths, heights, network.constants, block, h, gravity, drag)
    _update(x, v, T, dx, b, bad, False, lengths, network.constants, block, h)
    if restart:
        _solve(A, b, x, v, vh, T, mass, lengths, heights, network.constants, block, h, gravity, drag)
        _update(x, v, T, dx, b, bad, True, lengths, network.constants, block, h)
