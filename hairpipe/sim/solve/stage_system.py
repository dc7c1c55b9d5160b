"""The system of one linearly implicit stage of a strand, assembled and eliminated row by row.

See `implicit_stage.py` for the equation and external forces.
"""

from hairpipe.kernels.banded import add
from hairpipe.kernels.compile import inlined
from hairpipe.kernels.simd import load, store
from hairpipe.sim.solve.spring_form import SpringForm
from hairpipe.sim.strands.band import (
    add_inertia,
    add_next,
    add_point,
    eliminate,
    fix_lanes,
    fix_root,
    start_row,
)
from hairpipe.sim.strands.interface import Terms, add_forces, shape_of

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
    """Write the factors to A, and to b the right-hand side of the back substitution for the change of velocity [m/s].

    Returns the lowest pivots of positions, and of angles, where a model has these; the others are positive.
    """
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
