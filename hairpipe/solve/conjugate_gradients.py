"""Coupled strands: conjugate gradients on the impulses that they exchange; the strands themselves are solved exactly.

The system is (P + O) x = b, with P one banded matrix per strand and O the couplings, which involve only points of
their axes (`solve/couplings.py`). Preconditioned by P, and started from the uncoupled solution, x0 = P^-1
b, every residual lies on the axes too, as does P times every search direction:

    x = x0 + P^-1 R^T s,   r = -O (u + R P^-1 R^T s),   u = R x0,   R: take the axis points

s being the impulses on points from other strands. So all vectors are (points, 3), independently of particles off the
axis; there is no product with P, as P p follows from P z = r by the recurrence of p itself. The caller provides z = R
P^-1 R^T r, and receives s. Vectors are in single precision, since their cost is memory traffic. Sums run in an order
that does not depend on threads.

The iterations end when sqrt(r . z), the motion of uncoupled strands by the residual, is a given fraction of the mass
norm of R x. Bundles that move as one are less stiff than their strands one by one, so the error of x is larger, in
proportion to the strength of the coupling. It falls in every iteration; if they end early, strands are coupled to the
previous estimate of the others.

Impulses between strands are opposite up to this error: of an impulse between two free hairs a tenth was spurious at
1/240 s. Applying the impulse of every coupling once more, on both sides, from the final velocities conserves momentum
to rounding, and was rejected: contact is so stiff that the small error of x is a large impulse, hair crossed hair more
often and steps became shorter, `bench paper long_straight_5000` took 27.0 s per frame instead of 6.3; with
2,000 strands and a tolerance of 1e-2 it took 6.3 instead of 2.3, and 9.1 if couplings first absorbed the residual as
if points were free.

The own blocks of the couplings are part of each strand's system. Strands that are solved again use the resulting
positions of the others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load, store, width
from hairpipe.solve.couplings import (
    NOWHERE,
    CouplingRows,
    Incidence,
    Places,
    coupling_rows,
    couplings_at,
    find_incidence,
    follow,
    impulses_after,
    join,
    multiply_across,
    part_of,
)
from hairpipe.solve.implicit_stage import copy_active
from hairpipe.solve.interactions import Interaction, Prediction

MOST = 200
"""Iterations."""
STILL = 1e-4
"""Change of velocity below which the tolerance is not relative, at the usual scale [m/s]: what rests is not solved to
the last bit, but well enough to lose its slow motions."""
_SINGLE = np.float32
_WIDTH = width(_SINGLE)
_CHUNK = 512
"""Rows of lanes, and points, that are summed one after the other."""


class Exchange(NamedTuple):
    """Result of the exchange between coupled strands.

    impulses    impulses on points [N s], (points, 3) float32
    iterations  number of iterations
    error       estimated relative error of the motion of points, see above, in the norm of the mass
    """

    impulses: np.ndarray
    iterations: int
    error: float


def solve(
    respond: Callable[[np.ndarray, np.ndarray], None],
    multiply: Callable[[np.ndarray, np.ndarray, np.ndarray], None],
    alone: np.ndarray,
    masses: np.ndarray,
    tolerance: float = 1e-3,
    still: float = STILL,
    most: int = MOST,
) -> Exchange:
    """Find the impulses between strands.

    respond    respond(r, z) sets z, the motion of points [m/s], to R P^-1 R^T r for impulses r; 0 for held points
    multiply   multiply(v, start, out) sets out to start + O v, as `multiply_across` does; all of both are float32
    alone      uncoupled motion u of the points [m/s], (points, 3)
    masses     masses of the points, inf if held [kg], (points,)
    tolerance  largest estimated error
    still      change of velocity below which it is not relative [m/s]
    most       maximum number of iterations

    A strand with a NaN here or in the result of respond is treated as held, so that the others are unaffected.
    """
    rows = -(-alone.size // _WIDTH)
    vectors = np.zeros((7, rows, _WIDTH), _SINGLE)  # Filled up to whole vectors with zeros, which add nothing to sums.
    s, r, z, p, q, w, x = vectors
    points = [vector.reshape(-1)[: alone.size].reshape(-1, 3) for vector in vectors]
    _take_finite(alone, points[6])
    multiply(points[6], points[0], points[1])  # r = -O x0, as x0 solves the systems of the strands; s is still 0.
    np.negative(r, out=r)
    size = _size(masses, points[6], still)
    before = np.inf  # Makes beta 0 in the first iteration, so that p starts as z.
    rz = 0.0
    made = 0
    while True:
        respond(points[1], points[2])
        rz = _turn(before, r, z, p, q)
        if rz <= tolerance * tolerance * size:
            # The norm of x costs a pass over memory: it is renewed only where the old one would end the iterations.
            size = _size(masses, points[6], still)
        if not tolerance * tolerance * size < rz < np.inf or made == most:  # In this order, a NaN ends the iterations.
            break
        multiply(points[3], points[4], points[5])
        if not _advance(rz, p, q, w, s, r, x):
            break
        before = rz
        made = made + 1
    return Exchange(points[0], made, float(np.sqrt(rz / size)) if rz > 0.0 else 0.0)


@njit(cache=True, parallel=True)
def _take_finite(x, out):
    """Set out to x, and to 0 where that is not finite, in place."""
    for k in prange(len(x)):
        for c in range(3):
            out[k, c] = x[k, c] if abs(x[k, c]) < np.inf else 0.0


@njit(cache=True, parallel=True)
def _size(masses, x, slow):
    """Square of the mass norm [J], in a fixed order."""
    chunks = -(-len(x) // _CHUNK)
    moving, still = np.zeros(chunks), np.zeros(chunks)
    for chunk in prange(chunks):
        for k in range(np.int64(chunk) * _CHUNK, min((np.int64(chunk) + 1) * _CHUNK, len(x))):
            if masses[k] < np.inf:
                square = np.float64(x[k, 0]) ** 2 + np.float64(x[k, 1]) ** 2 + np.float64(x[k, 2]) ** 2
                moving[chunk] += masses[k] * square
                still[chunk] += masses[k] * slow * slow  # Of slow hair: a floor for the tolerance.
    total, least = 0.0, 0.0
    for chunk in range(chunks):  # One after another: a sum over threads would depend on their number.
        total, least = total + moving[chunk], least + still[chunk]
    return max(total, least)


@njit(cache=True, parallel=True)
def _turn(before, r, z, p, q):
    """Return r . z, and update the direction, in place: p = z + beta p, q = P p."""
    chunks = -(-len(r) // _CHUNK)
    sums = np.empty((chunks, _WIDTH), _SINGLE)
    for chunk in prange(chunks):
        _sum_finite(sums, np.int64(chunk), r, z)
    rz = _total(sums)
    beta = rz / before
    for chunk in prange(chunks):  # A second pass, as beta needs the whole sum.
        _turn_some(np.int64(chunk) * _CHUNK, beta, r, z, p, q)
    return rz


@njit(cache=True, parallel=True)
def _advance(rz, p, q, w, s, r, x):
    """Go along p to the least error, in place: x += step p, s and r with it; tell whether there is one."""
    chunks = -(-len(r) // _CHUNK)
    sums = np.empty((chunks, _WIDTH), _SINGLE)
    for chunk in prange(chunks):
        _sum(sums, np.int64(chunk), p, w)
    curvature = _total(sums)
    goes = 0.0 < curvature < np.inf
    if goes:
        step = rz / curvature
        for chunk in prange(chunks):
            _advance_some(np.int64(chunk) * _CHUNK, step, p, q, w, s, r, x)
    return goes


@inlined
def _total(sums):
    total = 0.0
    for chunk in range(sums.shape[0]):  # A chunk is short enough for single precision; the sum over chunks is not.
        for lane in range(sums.shape[1]):
            total += np.float64(sums[chunk, lane])
    return total


@njit(cache=True)
def _sum_finite(sums, chunk, r, z):
    """Sum r z over a chunk; where that is not a number the unknown is held, in place."""
    for row in range(chunk * _CHUNK, min((chunk + 1) * _CHUNK, len(r))):
        for lane in range(_WIDTH):
            if not abs(r[row, lane] * z[row, lane]) < np.inf:
                r[row, lane], z[row, lane] = _SINGLE(0.0), _SINGLE(0.0)
    _sum(sums, chunk, r, z)


@njit(cache=True)
def _sum(sums, chunk, x, y):
    begin = chunk * _CHUNK
    total = load(x, (begin,)) * load(y, (begin,))
    # Each lane has its own sum: the additions are vectorised without a change of their order.
    for row in range(begin + 1, min(begin + _CHUNK, len(x))):
        total = total + load(x, (row,)) * load(y, (row,))
    store(sums, (chunk,), total)


@njit(cache=True)
def _turn_some(begin, beta, r, z, p, q):
    for row in range(begin, min(begin + _CHUNK, len(r))):
        store(p, (row,), load(z, (row,)) + beta * load(p, (row,)))
        store(q, (row,), load(r, (row,)) + beta * load(q, (row,)))  # q = P p needs no product, as P z = r.


@njit(cache=True)
def _advance_some(begin, step, p, q, w, s, r, x):
    for row in range(begin, min(begin + _CHUNK, len(r))):
        store(x, (row,), load(x, (row,)) + step * load(p, (row,)))
        store(s, (row,), load(s, (row,)) + step * load(q, (row,)))
        store(r, (row,), load(r, (row,)) - step * load(w, (row,)))


_TOLERANCE = 6e-2
"""Relative, of the change of velocity, see `solve`: step-to-step noise of contact exceeds the remaining error."""


@dataclass(eq=False)
class StrandCoupling:
    """The couplings of a step; `begin` is called first, and `linearise` before the other methods.

    interactions  that couple strands, in the order of their couplings
    speed         factor on the speed of what rests [1], see `Scale`
    """

    interactions: Sequence[Interaction]
    speed: float = 1.0
    _places: Places = field(init=False)
    _bounds: np.ndarray = field(init=False)
    _incidence: Incidence = field(init=False)
    _rows: CouplingRows = field(init=False)
    _change: np.ndarray | None = field(default=None, init=False)

    def __bool__(self) -> bool:
        """Whether anything couples strands."""
        return len(self.interactions) > 0

    def begin(self, points: int) -> None:
        """Collect what a step couples, of so many points."""
        places = [interaction.places for interaction in self.interactions]
        self._places = places[0] if len(places) == 1 else join(*places)
        self._bounds = np.cumsum([0, *(len(some.segments) for some in places)])
        self._incidence = find_incidence(self._places.segments, points)

    def linearise(self, at: Prediction) -> None:
        """Linearise all couplings at a prediction."""
        couplings = couplings_at(self._places)
        for interaction, (first, last) in zip(self.interactions, pairwise(self._bounds.tolist()), strict=True):
            interaction.couple(at, part_of(couplings, first, last))
        self._rows = coupling_rows(couplings, self._incidence)
        self._change = None  # No solve has moved strands since these were linearised.

    @property
    def own(self) -> tuple[np.ndarray, np.ndarray]:
        """Blocks by which impulses change with the strand's own velocities [kg], two of (P, 6) float32."""
        return self._rows.diagonal, self._rows.following

    def impulses(self, active: np.ndarray, out: np.ndarray) -> None:
        """Set out, (P, 3) [N s], to what active points, (P,) bool, get where solves have left all of them, in place."""
        if self._change is None:
            copy_active(active, self._rows.push, out)
        else:
            impulses_after(self._rows, self._change, active, out)

    def exchange(
        self, respond: Callable[[np.ndarray, np.ndarray], None], alone: np.ndarray, masses: np.ndarray
    ) -> np.ndarray:
        """Return the impulses that strands exchange [N s], (P, 3) float32; see `solve`."""

        def multiply(v: np.ndarray, start: np.ndarray, out: np.ndarray) -> None:
            multiply_across(self._rows, v, start, out)

        return solve(respond, multiply, alone, masses, _TOLERANCE, STILL * self.speed).impulses

    def follow(self, change: np.ndarray, active: np.ndarray, received: np.ndarray) -> None:
        """Update for a solve that changed velocities of active points, (P,) bool, by a change [m/s], (P, 3).

        received  in: their first impulses with those exchanged; out: their final impulses [N s], (P, 3)

        The exchanged impulses replace -O dv: contact is so stiff that the small error of dv would be a large impulse.
        """
        if self._change is None:
            self._change = np.zeros(change.shape)
        follow(self._rows, change, active, self._change, received)

    def release(self) -> None:
        """Free what only the solves of a step need."""
        self._places = NOWHERE
        self._incidence = find_incidence(NOWHERE.segments, 0)
        self._rows = coupling_rows(couplings_at(NOWHERE), self._incidence)
