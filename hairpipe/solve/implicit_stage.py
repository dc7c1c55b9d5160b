"""One linearly implicit stage of a time integrator: assemble, eliminate and substitute, fused per block of strands.

A stage solves for the velocity v at its end, with x = xh + h v, such that M (v - vh) = h f(x, v). Linearised once at a
guess,

    (M + h D + h^2 K) dv = M (vh - v) + h (f(x) - D v),   v += dv,  x += h dv.

Every integrator is a sequence of such stages; they differ in h, xh, vh and the guess. Strands of one stage may differ
in h, too: all strands in contact form one system, whatever their history.

External forces enter the system as values at each point of the axis, `outer` (rows / stride, 9 or 15, W): an impulse
to add to the right-hand side [N s], a symmetric block to add to that on the diagonal [kg], and one to that between the
point and the next [kg]; no rows without external forces. The rows of block b begin at first[b] // stride.

The system of one linearly implicit stage of a strand, assembled and eliminated row by row.

See `implicit_stage.py` for the equation and external forces.

External forces on points as the rows that `solve/implicit_stage.py` adds to the system of every strand.

Forces push - damping v [N] become an impulse and its matrix over the weight h of a stage's end,

    h (push - damping v) + received,   h damping + diagonal,   following

where `received` is the impulse from other strands, with its own blocks: see `solve/couplings.py`.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.banded import add
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import any_lane, copy, either, fill, load, select, store, store_as
from hairpipe.laws.stretch import SpringForm, multiplier
from hairpipe.solve.band import (
    add_inertia,
    add_next,
    add_point,
    eliminate,
    fix_lanes,
    fix_root,
    row_size,
    start_row,
    substitute,
)
from hairpipe.solve.stage import Iterate, Rule, Stage, System
from hairpipe.solve.stretch import overstrained, set_tensions
from hairpipe.strands.interface import (
    StiffnessPart,
    Terms,
    add_forces,
    follow_solve,
    hold_tip,
    largest_turn,
    least_pivot,
    predict,
    shape_of,
    spring_constant,
    springs_from,
)
from hairpipe.strands.layout import Axis

_EXPLICIT = int(SpringForm.explicit)


@inlined
def _start_row(model, system, mass, speeds, p, h, rule):
    """Inertia, weight and air drag of particle p; speeds  vh and v [m/s]."""
    (A, b), (vh, v) = system, speeds
    start_row(model, A, p, b.shape[0])
    m = load(mass, (p,))
    for c in range(3):
        speed = load(v, (p, c))
        store(b, (p, c), m * (load(vh, (p, c)) - speed + h * (rule.gravity[c] - rule.drag * speed)))
    for c in range(3, shape_of(model).unknowns):  # Twist has no inertia.
        store(b, (p, c), 0.0)
    add_inertia(model, A, p, m * (1.0 + h * rule.drag))


@inlined
def _six(outer, n, c):
    first = load(outer, (n, c)), load(outer, (n, c + 1)), load(outer, (n, c + 2))
    return (*first, load(outer, (n, c + 3)), load(outer, (n, c + 4)), load(outer, (n, c + 5)))


@inlined
def _add_outer(model, A, b, outer, p, n, last):
    """Add what acts from outside on particle p, the point n of its axis, of which the last is that particle."""
    for c in range(3):
        add(b, p, c, load(outer, (n, c)))
    add_point(model, A, p, _six(outer, n, 3))
    if outer.shape[1] > 9 and p < last:  # Blocks between points exist where hair couples hair; the tip has no next.
        add_next(model, A, p, _six(outer, n, 9))


@inlined
def assemble(model, block, system, at, outer, stage, h, rule):
    """Write the factors to A, and to b the right-hand side of the back substitution for the velocity [m/s]."""
    A, b = system
    x, v = at.x, at.v
    vh, held = stage.vh, stage.held
    count = x.shape[0]
    reach = shape_of(model).reach
    clamped = shape_of(model).clamped
    stride = shape_of(model).stride
    last = count - 1 - shape_of(model).after
    mass = model.mass[model.first[block] : model.first[block + 1]]
    hh = (0.0 if rule.form == _EXPLICIT else 1.0) * h * h  # Without h^2 K springs are explicit; damping stays.
    lowest = 0.0 * h + 1.0, 0.0 * h + 1.0
    terms = Terms(h, hh, rule.damping, rule.part)
    for p in range(min(reach, count)):  # `reach` ahead: forces and elimination of p add to rows up to p + reach.
        _start_row(model, system, mass, (vh, v), p, h, rule)
    for p in range(count):
        if p + reach < count:
            _start_row(model, system, mass, (vh, v), p + reach, h, rule)
        add_forces(model, system, at, p, block, terms)
        past = p + 1 - clamped  # Point n of the axis is particle clamped - 1 + n stride: others have no outer terms.
        if outer.shape[0] > 0 and past >= 0 and p <= last and past % stride == 0:
            _add_outer(model, A, b, outer, p, past // stride, last)
        if p < clamped:
            # Cleared after all forces have been added and before elimination would take them on to free rows.
            lowest = fix_root(model, A, b, p, count, lowest)
        else:
            if len(held) > 0 and p >= count - clamped:
                fix_lanes(model, A, b, p, load(held, (block,)) > 0.0)
            lowest = eliminate(model, A, b, p, count, lowest)
    return lowest


_PROJECTED = int(StiffnessPart.projected)
_, _PRINTED, _TENSION, _MULTIPLIER = (int(form) for form in SpringForm)


@njit(cache=True, error_model="numpy")
def _update(model, block, at, b, bad, only_bad, h, rule):
    """Move to the solution; with only_bad, in the flagged lanes only."""
    x, v, T = at
    if only_bad and shape_of(model).unknowns > 3:
        for p in range(x.shape[0]):  # `follow_solve` of a rod reads b: lanes that stay change no angle.
            for c in range(shape_of(model).unknowns):
                store(b, (p, c), select(bad, load(b, (p, c)), 0.0))
    count = x.shape[0]
    first = model.first[block]
    dx = np.empty(x.shape, x.dtype)
    for p in range(count):
        for c in range(3):
            dv = load(b, (p, c))
            if only_bad:
                dv = select(bad, dv, 0.0)
            store(dx, (p, c), h * dv)
            store(v, (p, c), load(v, (p, c)) + dv)
    if rule.form == _MULTIPLIER:
        for p in range(count):
            for o in range(1, springs_from(model, p, count) + 1):  # Before x moves: the system was made at the old x.
                k = spring_constant(model, block, p, o)
                t = multiplier(x, dx, p, o, k, load(model.inverse_lengths, (first + p, o - 1)))
                if only_bad:
                    t = select(bad, t, load(T, (p, o - 1)))
                store(T, (p, o - 1), t)
    follow_solve(model, block, at, dx, b, h)
    for p in range(count):
        for c in range(3):
            store(x, (p, c), load(x, (p, c)) + load(dx, (p, c)))


@inlined
def _place_ends(x, v, xh, ends, held, block, clamped, h):
    """Place held particles at their ends, with the velocity of that displacement."""
    count = x.shape[0]
    for p in range(clamped):
        for c in range(3):
            end = load(ends, (p, c))
            store(x, (p, c), end)
            store(v, (p, c), (end - load(xh, (p, c))) / h)
    if len(held) > 0:
        fixed = load(held, (block,)) > 0.0  # The tip may be held in some lanes of a block only.
        for i in range(clamped):
            p = count - clamped + i
            for c in range(3):
                end = load(ends, (clamped + i, c))
                store(x, (p, c), select(fixed, end, load(x, (p, c))))
                store(v, (p, c), select(fixed, (end - load(xh, (p, c))) / h, load(v, (p, c))))


@inlined
def _guess(model, block, at, stage, h, guard):
    """Place a block where its guess leads; return the lanes that are strained too much there."""
    x, v = at.x, at.v
    for p in range(x.shape[0]):
        for c in range(3):
            store(x, (p, c), load(stage.xh, (p, c)) + h * load(v, (p, c)))
    _place_ends(x, v, stage.xh, stage.ends, stage.held, block, shape_of(model).clamped, h)
    bad = overstrained(model, x, block, guard)
    # Backward Euler, whose weight is the span, is of first order, and what it predicts of long steps is too much.
    predict(model, at.T, stage.span, either(bad, stage.span + 0.0 * h <= h))
    return bad


@inlined
def _restart(model, block, at, stage, h, bad):
    """Place the lanes that are bad as the stage began, along with their roots."""
    x = at.x
    v = at.v
    before = stage.before
    ends = stage.ends
    clamped = shape_of(model).clamped
    for p in range(clamped, x.shape[0]):
        for c in range(3):
            # A rigid shift with the root: edges keep the lengths that they had when the stage began.
            along = load(ends, (clamped - 1, c)) - load(before, (clamped - 1, c))
            store(x, (p, c), select(bad, load(before, (p, c)) + along, load(x, (p, c))))
            store(v, (p, c), select(bad, (load(x, (p, c)) - load(stage.xh, (p, c))) / h, load(v, (p, c))))
    _place_ends(x, v, stage.xh, ends, stage.held, block, clamped, h)


@njit(cache=True, error_model="numpy")
def run_stage(model, block, at, stage, rule):
    """Advance one block of strands through a stage without external forces, in place.

    at     an Iterate, in: its v is the guess; out: at the end of the stage
    stage  stage of the block
    """
    x = at.x
    T = at.T
    h = load(stage.h, (block,))
    A, b = _room(model, x)
    nothing = np.empty((0, 9, x.shape[2]), x.dtype)
    bad = _guess(model, block, at, stage, h, rule.guard)
    if any_lane(bad):
        _restart(model, block, at, stage, h, bad)
    # One pass more for the lanes that restarted: they are farther from the solution; the others are left as they are.
    for iteration in range(rule.iterations + int(any_lane(bad))):
        set_form(model, block, x, T, rule)
        hold_tip(model, block, x, T, stage.held)
        _solve_definite(model, block, System(A, b), at, nothing, stage, (h, h < 0.0), rule)
        _update(model, block, at, b, bad, iteration == rule.iterations, h, rule)


@njit(cache=True)
def _room(model, x):
    """Make room for the matrix and the right-hand side of a block at x, (rows, 3, W)."""
    numbers = row_size(shape_of(model))
    unknowns = shape_of(model).unknowns
    return np.empty((x.shape[0], numbers, x.shape[2]), x.dtype), np.empty((x.shape[0], unknowns, x.shape[2]), x.dtype)


@inlined
def set_form(model, block, x, T, rule):
    """Set T, in place, to the tension of the spring form in the matrix: 0, the present one, or unchanged."""
    if rule.form <= _PRINTED:
        fill(T, 0.0)
    elif rule.form == _TENSION:
        set_tensions(model, block, x, T)


@njit(cache=True)
def _of_block(model, block, at, stage):
    """Return the iterate and the stage of one block; memory is shared."""
    rows = slice(model.first[block], model.first[block + 1])
    part = Stage(
        stage.xh[rows],
        stage.vh[rows],
        stage.before[rows],
        stage.began[rows],
        stage.ends[block],
        stage.held,
        stage.h,
        stage.time,
        stage.span,
    )
    return Iterate(at.x[rows], at.v[rows], at.T[rows]), part


@njit(cache=True, parallel=True)
def run_stages(model, at, stage, rule):
    """Advance all strands through a stage that nothing from outside takes part in, in place; see `run_stage`."""
    for block in prange(len(model.first) - 1):
        # Numba counts blocks without sign, and would compile all below for that once more.
        _run_block(model, np.int64(block), at, stage, rule)


@njit(cache=True)
def _run_block(model, block, at, stage, rule):
    part, its_stage = _of_block(model, block, at, stage)
    run_stage(model, block, part, its_stage, rule)


@njit(cache=True, parallel=True)
def guess_stages(model, at, stage, rule):
    """Begin a stage: place all strands at the positions of their guess, in place; see `run_stage`.

    A strand strained too much by this is solved alone, by backward Euler over the span from the start of the stage: vh
    contains the spring forces, which balanced the contact forces on the strand, and would fling it without them.
    """
    for block in prange(len(model.first) - 1):
        _guess_block(model, np.int64(block), at, stage, rule)


@njit(cache=True, error_model="numpy")
def _guess_block(model, block, at, stage, rule):
    h = load(stage.h, (block,))
    part, its_stage = _of_block(model, block, at, stage)
    bad = _guess(model, block, part, its_stage, h, rule.guard)
    if any_lane(bad):
        _fall_back(model, block, part, its_stage, h, bad, rule)


@njit(cache=True, error_model="numpy")
def _fall_back(model, block, at, stage, h, bad, rule):
    """Solve the bad lanes with backward Euler over the span of the stage, in place."""
    x, v, T = at
    before = stage.before
    ends = stage.ends
    span = 0.0 * h + stage.span
    count = x.shape[0]
    A, b = _room(model, x)
    moved, speeds, tensions = np.empty(x.shape, x.dtype), np.empty(x.shape, x.dtype), np.empty(T.shape, T.dtype)
    copy(tensions, T)  # A copy, as the lanes that are not bad keep their T.
    clamped = shape_of(model).clamped
    for p in range(count):
        for c in range(3):
            along = load(ends, (clamped - 1, c)) - load(before, (clamped - 1, c))
            store(moved, (p, c), load(before, (p, c)) + along)
            store(speeds, (p, c), along / span)
    _place_ends(moved, speeds, before, ends, stage.held, block, clamped, span)
    set_form(model, block, moved, tensions, rule)
    hold_tip(model, block, moved, tensions, stage.held)
    nothing = np.empty((0, 9, x.shape[2]), x.dtype)
    advanced = Iterate(moved, speeds, tensions)
    euler = Stage(before, stage.began, before, stage.began, ends, stage.held, stage.h, stage.time, stage.span)
    _solve_definite(model, block, System(A, b), advanced, nothing, euler, (span, h < 0.0), rule)
    _update(model, block, advanced, b, bad, True, span, rule)
    for p in range(count):
        for c in range(3):
            store(x, (p, c), select(bad, load(moved, (p, c)), load(x, (p, c))))
            # Not the velocity found: in every lane x = xh + h v must hold for the solves that follow.
            store(v, (p, c), select(bad, (load(x, (p, c)) - load(stage.xh, (p, c))) / h, load(v, (p, c))))
        for o in range(T.shape[1]):
            store(T, (p, o), select(bad, load(tensions, (p, o)), load(T, (p, o))))


@njit(cache=True, parallel=True)
def factor_stages(model, system, at, outer, active, stage, rule):
    """Solve every strand's own system, in place.

    system  a System, out: factors and change of velocity of the blocks with strands to solve
    at      an Iterate, where the system is linearised; its T is set by the spring form
    outer   external forces, see above
    active  1 for strands to solve, 2 with the projected stiffness, (blocks, W), out: 2 for those that took it; the
            others in their blocks have 0 in b
    """
    for block in prange(len(model.first) - 1):
        if active[block].any():
            _factor_block(model, np.int64(block), system, at, outer, active, stage, rule)


@njit(cache=True, parallel=True)
def find_overturned(model, b, active, weights):
    """Mark strands with a frame that the solution b turns too far, in place, where they had the exact stiffness.

    active   1 for strands that were solved, 2 with the projected stiffness, which is set, (blocks, W)
    weights  h of the stage [s], (blocks, W)

    Returns the number of blocks in which there are any.
    """
    found = 0
    for block in prange(len(model.first) - 1):
        found += _mark_overturned(model, np.int64(block), b, active, weights)
    return found


@njit(cache=True, error_model="numpy")
def _mark_overturned(model, block, b, active, weights):
    turn = largest_turn(model, block, b[model.first[block] : model.first[block + 1]], load(weights, (block,)))
    asked = load(active, (block,))
    marked = select(turn > 1.0, select(asked > 0.0, 0.0 * asked + 2.0, asked), asked)
    store(active, (block,), marked)
    return np.int64(any_lane(marked > asked))


@njit(cache=True, error_model="numpy")
def _solve_definite(model, block, system, at, outer, stage, lanes, rule):
    """Factor the system of a block and replace its right-hand side by the solution, in place.

    Lanes whose matrix is not positive definite, lanes with a frame that the solution turns too far, and those of the
    mask `firm` take the projected stiffness. The solution of an indefinite system is a saddle point of the energy, at
    any distance; and after a large turn the torque has another sign. Strands that touch would follow both.

    lanes  h of the stage [s], and firm

    Returns the mask of lanes that took the projected stiffness.
    """
    h, firm = lanes
    full = system
    doubtful = firm
    lowest = h, h
    for attempt in range(2 if shape_of(model).unknowns > 3 and rule.part != _PROJECTED else 1):
        if attempt == 1:
            indefinite = either(lowest[0] <= 0.0, lowest[1] <= least_pivot(model, block, h * h))
            doubtful = either(either(firm, indefinite), largest_turn(model, block, system.b, h) > 1.0)
            if not any_lane(doubtful):
                break
            full = System(system.A.copy(), system.b.copy())
            rule = _with_part(rule, _PROJECTED)
        lowest = assemble(model, block, system, at, outer, stage, h, rule)
        substitute(model, system.A, system.b, at.x.shape[0])
        if attempt == 1:
            # The projected stiffness is for the lanes that need it; the others keep the exact one, to the bit.
            _take_back(system.A, full.A, doubtful)
            _take_back(system.b, full.b, doubtful)
    return doubtful


@inlined
def _with_part(rule, part):
    """Return the rule with another part of the stiffness: numba knows no `_replace`."""
    return Rule(rule.form, rule.damping, rule.guard, rule.iterations, rule.gravity, rule.drag, part)


@inlined
def _take_back(new, old, kept):
    """Restore the previous values, in place, except in kept lanes."""
    for p in range(new.shape[0]):
        for c in range(new.shape[1]):
            store(new, (p, c), select(kept, load(new, (p, c)), load(old, (p, c))))


@njit(cache=True, error_model="numpy")
def _factor_block(model, block, system, at, outer, active, stage, rule):
    rows = slice(model.first[block], model.first[block + 1])
    h = load(stage.h, (block,))
    part, its_stage = _of_block(model, block, at, stage)
    A = system.A
    bs = system.b[rows]
    xs = part.x
    As = _room(model, xs)[0]  # In the precision of the model, in a buffer of the block; `store_as` below rounds.
    set_form(model, block, xs, part.T, rule)
    hold_tip(model, block, xs, part.T, its_stage.held)
    axis = slice(rows.start // shape_of(model).stride, rows.stop // shape_of(model).stride)
    asked = load(active, (block,))
    firm = _solve_definite(model, block, System(As, bs), part, outer[axis], its_stage, (h, asked > 1.0), rule)
    store(active, (block,), select(firm, select(asked > 0.0, 0.0 * asked + 2.0, asked), asked))
    for p in range(bs.shape[0]):
        for c in range(bs.shape[1]):
            store(bs, (p, c), select(asked > 0.0, load(bs, (p, c)), 0.0))
    if A.shape[0] > 0:
        kept = A[rows]  # Conjugate gradients read these factors in every iteration: this is their time.
        for p in range(kept.shape[0]):
            for c in range(kept.shape[1]):
                store_as(kept, (p, c), load(As, (p, c)))


@njit(cache=True, parallel=True)
def update_stages(model, at, b, active, weights, rule):
    """Move the active strands, (blocks, W), to the solution b, in place; weights  h of the stage [s], (blocks, W)."""
    for block in prange(len(model.first) - 1):
        if active[block].any():
            _update_block(model, np.int64(block), at, b, active, weights, rule)


@njit(cache=True, error_model="numpy")
def _update_block(model, block, at, b, active, weights, rule):
    rows = slice(model.first[block], model.first[block + 1])
    h = load(weights, (block,))
    part = Iterate(at.x[rows], at.v[rows], at.T[rows])
    _update(model, block, part, b[rows], load(active, (block,)) > 0.0, True, h, rule)


ROWS, ROWS_WITH_NEXT = 9, 15
"""Numbers of a point: an impulse and a block; those and the block between it and the next on the axis."""


class ExternalTerms(NamedTuple):
    """External forces on points in a solve.

    push       [N], (P, 3)
    damping    symmetric, xx xy xz yy yz zz [kg/s], (P, 6)
    received   impulses from other strands [N s], (P, 3); no rows if strands are not coupled
    diagonal   block of the couplings between a point and itself [kg], (P, 6) float32; no rows likewise
    following  block between a point and the next of its strand [kg], (P, 6) float32; no rows likewise
    """

    push: np.ndarray
    damping: np.ndarray
    received: np.ndarray
    diagonal: np.ndarray
    following: np.ndarray


@njit(cache=True, parallel=True)
def clear(active: np.ndarray, push: np.ndarray, damping: np.ndarray) -> None:
    """Set push (P, 3) and damping (P, 6) of active points, (P,) bool, to zero, in place."""
    for k in prange(len(active)):
        if active[k]:
            push[k] = 0.0
            damping[k] = 0.0


@njit(cache=True, parallel=True)
def copy_active(active: np.ndarray, values: np.ndarray, out: np.ndarray) -> None:
    """Set out, (P, 3), of active points, (P,) bool, to values, in place."""
    for k in prange(len(active)):
        if active[k]:
            for c in range(3):
                out[k, c] = values[k, c]


@njit(cache=True, parallel=True)
def add_impulses(impulses: np.ndarray, out: np.ndarray) -> None:
    """Add impulses [N s] to out, both (P, 3), in place."""
    for k in prange(len(out)):
        for c in range(3):
            out[k, c] += impulses[k, c]


@njit(cache=True, parallel=True)
def set_contact_dv(active: np.ndarray, impulses: np.ndarray, masses: np.ndarray, out: np.ndarray) -> None:
    """Set out, (P, 3) [m/s], of active points, (P,) bool, to impulses [N s] over masses [kg], (P,), in place."""
    for k in prange(len(active)):
        if active[k]:
            for c in range(3):
                out[k, c] = impulses[k, c] / masses[k]


@njit(cache=True, parallel=True)
def lay_out(axis: Axis, active, terms: ExternalTerms, velocities, weights, outer) -> None:
    """Write the rows of active strands, (blocks, W), in place.

    velocities  velocities v of points [m/s], (P, 3)
    weights     weight h of the end of the stage, for every strand [s], (blocks, W)
    outer       (rows / stride, 9 or 15, W)
    """
    for block in prange(len(axis.first) - 1):
        if active[block].any():
            _lay_out_block(axis, np.int64(block), terms, velocities, weights, outer)


@njit(cache=True)
def _lay_out_block(axis, block, terms, velocities, weights, outer):
    push, damping, received, diagonal, following = terms
    touching = len(received) > 0
    for lane in range(axis.strands.shape[1]):
        strand = axis.strands[block, lane]
        row = axis.first[block] // axis.stride  # `outer` has rows for the points of the axis only.
        h = weights[block, lane]
        for k in range(axis.offsets[strand], axis.offsets[strand + 1]):
            d = damping[k]
            x = velocities[k, 0]
            y = velocities[k, 1]
            z = velocities[k, 2]
            outer[row, 0, lane] = h * (push[k, 0] - d[0] * x - d[1] * y - d[2] * z)
            outer[row, 1, lane] = h * (push[k, 1] - d[1] * x - d[3] * y - d[4] * z)
            outer[row, 2, lane] = h * (push[k, 2] - d[2] * x - d[4] * y - d[5] * z)
            for c in range(6):
                outer[row, 3 + c, lane] = h * d[c]
            if touching:
                for c in range(3):  # Already impulses: they are not multiplied by h.
                    outer[row, c, lane] += received[k, c]
                for c in range(6):
                    outer[row, 3 + c, lane] += diagonal[k, c]
                    outer[row, 9 + c, lane] = following[k, c]
            row += 1
