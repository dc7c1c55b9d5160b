"""Impulses between coupled strands against one dense solve."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from hairpipe.geometry.simd_vec4 import WHOLE
from hairpipe.solve.conjugate_gradients import MOST, solve
from hairpipe.solve.couplings import Couplings, coupling_rows, find_incidence, multiply_across

from ..contact.coupled_strands import OFFSETS, own_matrix, random_couplings, whole_matrix

POINTS, STRANDS, LENGTH, MASS = 14, 10, 6e-3, 4e-8
"""Of a strand, strands; of a segment [m], of a point [kg]: real hair, 8 cm."""
MASSES = np.tile([np.inf, np.inf] + [MASS] * (POINTS - 2), STRANDS)


class Bundle(NamedTuple):
    """Strands side by side that stick to their neighbours, and one step of them."""

    strands: np.ndarray
    couplings: Couplings
    across: np.ndarray
    own: np.ndarray
    b: np.ndarray
    held: np.ndarray

    def solve(self, tolerance=1e-3, most=MOST, *, own=True):
        """Give the change of velocity by conjugate gradients, and the exchange."""
        # Without own blocks in the factors, O is all that couplings do.
        P, O = (self.strands + self.own, self.across) if own else (self.strands, self.across + self.own)
        inverse = invert_free(P, self.held)
        alone = (inverse @ self.b).reshape(-1, 3)

        def respond(r, z):
            z[:] = (inverse @ r.ravel()).reshape(-1, 3)

        def multiply(v, start, out):
            out[:] = start + (O @ v.ravel()).reshape(-1, 3)

        exchange = solve(respond, multiply, alone, MASSES, tolerance, most=most)
        return alone.ravel() + inverse @ exchange.impulses.ravel().astype(float), exchange

    def exact(self):
        return invert_free(self.strands + self.own + self.across, self.held) @ self.b


def invert_free(P, held):
    inverse = np.zeros_like(P)
    free = np.flatnonzero(~held)
    inverse[np.ix_(free, free)] = np.linalg.inv(P[np.ix_(free, free)])
    return inverse


def strand_matrix(x, h):
    """Inertia, stretch and bending of one strand, (3 POINTS, 3 POINTS)."""
    A = np.kron(np.diag(np.full(POINTS, MASS)), np.eye(3))
    d = np.diff(x, axis=0) / LENGTH
    for k in range(POINTS - 1):
        J = np.zeros((1, 3 * POINTS))
        J[0, 3 * k : 3 * k + 6] = np.concatenate([-d[k], d[k]])
        A += h * h * 20.0 / LENGTH * J.T @ J
    for k in range(1, POINTS - 1):
        J = np.zeros((3, 3 * POINTS))
        J[:, 3 * k - 3 : 3 * k + 6] = np.kron([1.0, -2.0, 1.0], np.eye(3))
        A += h * h * 8e-9 / LENGTH**3 * J.T @ J
    return A


@cache
def bundle(stiffness, h):
    """Make a bundle with connections of a stiffness [N/m], about six to a segment, in a step h [s]."""
    rng = np.random.default_rng(3)
    total = POINTS * STRANDS
    directions = [0, -1, 0] + 0.2 * rng.normal(size=(STRANDS, 3))
    roots = 1e-3 * rng.random((STRANDS, 3))
    steps = LENGTH * directions / np.linalg.norm(directions, axis=1)[:, None]
    x = roots[:, None] + np.arange(POINTS)[:, None] * steps[:, None]
    strands = np.zeros((3 * total, 3 * total))
    for s in range(STRANDS):
        rows = slice(3 * POINTS * s, 3 * POINTS * (s + 1))
        strands[rows, rows] = strand_matrix(x[s], h)
    at, other, level = np.meshgrid(range(STRANDS), range(1, 7), range(POINTS - 1), indexing="ij")
    at, level, other = at.ravel(), level.ravel(), (at.ravel() + other.ravel()) % STRANDS
    keep = at < other
    pairs = np.stack([at * POINTS + level, other * POINTS + level], axis=1)[keep].astype(np.int32)
    n = rng.normal(size=(len(pairs), 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    strength = np.tile(np.float32([h * h * stiffness, 0.0]), (len(pairs), 1))
    fractions, n = np.rint(rng.random((len(pairs), 2)) * WHOLE) / WHOLE, np.trunc(n * WHOLE) / WHOLE
    acts = np.full(len(pairs), stiffness > 0.0)
    exerted = np.concatenate([np.zeros((len(pairs), 3)), n, strength], axis=1)
    couplings = Couplings(pairs, fractions, acts, exerted)
    sides = coupling_rows(couplings, find_incidence(pairs, total))
    own = own_matrix(sides.diagonal, sides.following)
    forces = np.repeat(rng.normal(size=(STRANDS, 1, 3)), POINTS, axis=1).ravel() * MASS * 300.0 * h
    held = np.zeros((STRANDS, POINTS, 3), bool)
    held[:, :2] = True
    return Bundle(strands, couplings, whole_matrix(couplings, total) - own, own, forces, held.ravel())


def error(x, exact):
    return np.linalg.norm(x - exact) / np.linalg.norm(exact)


STEPS = [6e-4, 1 / 240, 1 / 60]


@pytest.mark.parametrize("stiffness", [1.5e-3, 1.0, 100.0])
@pytest.mark.parametrize("h", STEPS)
def test_the_default_tolerance_leaves_less_than_a_thousandth(stiffness, h):
    case = bundle(stiffness, h)
    x, exchange = case.solve()
    assert error(x, case.exact()) < 1e-3 and exchange.error <= 1e-3
    assert not x[case.held].any()


@pytest.mark.parametrize(
    ("stiffness", "h", "own", "without"),
    [
        (1.5e-3, 1 / 240, 4, 2),
        (1.5e-3, 1 / 60, 12, 9),
        (1.0, 6e-4, 14, 12),
        (1.0, 1 / 240, 24, 60),
        (1.0, 1 / 60, 24, 150),
        (100.0, 6e-4, 50, 90),
        (100.0, 1 / 240, 50, 200),
        (100.0, 1 / 60, 50, 200),
    ],
)
def test_own_blocks_in_the_factors_save_iterations(stiffness, h, own, without):
    """So many are enough for 1 % with them, and so many are not without: the trend of the survey's table."""
    case = bundle(stiffness, h)
    exact = case.exact()
    assert error(case.solve(0.0, own)[0], exact) < 1e-2
    assert error(case.solve(0.0, without, own=False)[0], exact) > 1e-2


def test_every_iteration_comes_nearer():
    case = bundle(1.0, 1 / 240)
    exact, P = case.exact(), case.strands + case.own + case.across
    energies = [(x - exact) @ P @ (x - exact) for x in (case.solve(0.0, most)[0] for most in range(25))]
    assert np.all(np.diff(energies) < 0)


def test_uncoupled_systems_need_no_iteration():
    case = bundle(0.0, 1 / 240)
    x, exchange = case.solve()
    assert exchange.iterations == 0 and exchange.error == 0.0 and not exchange.impulses.any()
    assert error(x, case.exact()) < 1e-12


def test_a_strand_that_is_lost_is_as_if_held_and_spares_the_others():
    case = bundle(1.0, 1 / 240)
    lost = np.zeros_like(case.held)
    lost[3 * POINTS * 5 : 3 * POINTS * 6] = True
    without = case._replace(held=case.held | lost)
    inverse, O = invert_free(case.strands + case.own, without.held), case.across

    def respond(r, z):
        z[:] = np.where(lost, np.nan, inverse @ r.ravel()).reshape(-1, 3)

    def multiply(v, start, out):
        out[:] = start + (O @ v.ravel()).reshape(-1, 3)

    alone = np.where(lost, np.nan, inverse @ case.b).reshape(-1, 3)
    exchange = solve(respond, multiply, alone, MASSES)
    assert np.isfinite(exchange.impulses).all()
    x = np.where(lost, 0.0, inverse @ case.b) + inverse @ exchange.impulses.ravel()
    assert error(x, without.exact()) < 1e-3


@pytest.mark.parametrize("bad", [np.nan, np.inf, -50.0])
def test_a_matrix_that_is_none_ends_finite(bad):
    case = bundle(1.0, 1 / 240)
    with np.errstate(invalid="ignore"):
        _, exchange = case._replace(across=bad * case.across).solve()
    assert np.isfinite(exchange.impulses).all() and exchange.iterations <= MOST


def test_threads_change_no_bit(same_on_threads):
    points = int(OFFSETS[-1]) * 4
    couplings = random_couplings(np.array([0, points], np.int32), 9000)
    sides = coupling_rows(couplings, find_incidence(couplings.segments, points))
    heavy = 2.0 * sides.diagonal.sum(axis=1)[:, None] + 1.0
    alone = np.random.default_rng(2).normal(size=(points, 3))

    def respond(r, z):
        z[:] = r / heavy

    def multiply(v, start, out):
        multiply_across(sides, v, start, out)

    found = same_on_threads(lambda: solve(respond, multiply, alone.copy(), np.ones(points), 1e-5))
    assert 5 < found.iterations < MOST
