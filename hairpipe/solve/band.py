"""Kernels for the banded matrix of a strand, by the number of unknowns per row of its model.

Three unknowns a row are `geometry/banded.py`, four are `geometry/banded_angle.py`, which also fix the layout of a row.
"""

from collections.abc import Callable

from numba.core.dispatcher import Dispatcher

from hairpipe.geometry import banded, banded_angle
from hairpipe.geometry.banded import add, clear_row, fix_row
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load, store
from hairpipe.strands.interface import ByModel, shape_of
from hairpipe.strands.layout import Shape


def inlined_by_unknowns(four: Dispatcher) -> Callable[[Callable], ByModel]:
    """Decorate the kernel for three unknowns a row; another one is compiled for four.

    A branch on `shape_of` selects as well, but both sides are compiled: it is for short kernels.
    """
    return lambda declaration: ByModel(declaration, lambda kind: four if kind.shape.unknowns == 4 else None)


@inlined
def row_size(shape: Shape) -> int:
    """Numbers in a row of the matrix."""
    return banded.row_size(shape.reach) if shape.unknowns == 3 else banded_angle.SIZE


@inlined
def _diagonal(model):
    """Places of the diagonal of x, y and z in a row of the matrix."""
    return (0, 3, 5) if shape_of(model).unknowns == 3 else (0, 11, 21)


@inlined
def start_row(model, A, p, count):
    """Clear row p of a strand of so many rows, in place: zero, and 1 on the diagonal where there is no equation."""
    clear_row(A, p)
    if shape_of(model).unknowns == 4:
        if p == count - 1:  # The last row is that of q', which has no equation: an identity keeps elimination regular.
            add_inertia(model, A, p, 1.0 + 0.0 * load(A, (p, 0)))
        if p >= count - 2:  # No edge begins at the last two rows: their angles have no equation either.
            store(A, (p, 30), 1.0)


@inlined
def add_inertia(model, A, p, inertia):
    """Add a mass to the position of row p, in lanes, in place."""
    x, y, z = _diagonal(model)
    add(A, p, x, inertia)
    add(A, p, y, inertia)
    add(A, p, z, inertia)


@inlined
def add_point(model, A, p, block):
    """Add a symmetric block, a tuple of six lanes, to the position of row p, in place."""
    if shape_of(model).unknowns == 3:
        banded.add_diagonal(A, p, *block)
    else:
        banded_angle.add_point(A, p, block)


@inlined
def add_next(model, A, p, block):
    """Add a symmetric block, six lanes, between the positions of row p and the next on the axis, in place."""
    if shape_of(model).unknowns == 3:
        banded.add_coupling(A, p, shape_of(model).stride, block)
    else:
        xx, xy, xz, yy, yz, zz = block
        for row, three in ((4, (xx, xy, xz)), (14, (xy, yy, yz)), (23, (xz, yz, zz))):
            add(A, p, row, three[0])
            add(A, p, row + 1, three[1])
            add(A, p, row + 2, three[2])


@inlined
def fix_lanes(model, A, b, p, fixed):
    """Hold row p in the lanes of a mask, in place."""
    if shape_of(model).unknowns == 3:
        banded.fix_lanes(A, b, p, fixed)
    else:
        banded_angle.fix_lanes(A, b, p, fixed)


@inlined
def _eliminate(model, A, b, p, count, lowest):
    return banded_angle.eliminate(A, b, p, count, lowest)


@inlined_by_unknowns(four=_eliminate)
def eliminate(model, A, b, p, count, lowest):
    """Eliminate row p, in place; return the lowest pivots of this and before, where they may be negative."""
    banded.eliminate(A, b, p, count, shape_of(model).reach)
    return lowest


@inlined
def _fix_root(model, A, b, p, count, lowest):
    """Only the angle of the root's own edge is free."""
    if p < shape_of(model).clamped - 1:
        fix_row(A, b, p)
        return lowest
    banded_angle.fix_position(A, b, p)
    return banded_angle.eliminate(A, b, p, count, lowest)


@inlined_by_unknowns(four=_fix_root)
def fix_root(model, A, b, p, count, lowest):
    """Hold row p at the root, in place; return the lowest pivots of this and before."""
    fix_row(A, b, p)
    return lowest


@inlined
def _forward(model, A, b, p, count):
    banded_angle.forward(A, b, p, count)


@inlined_by_unknowns(four=_forward)
def forward(model, A, b, p, count):
    """Eliminate row p from another right-hand side, as `eliminate`, in place."""
    banded.forward(A, b, p, count, shape_of(model).reach)


@inlined
def _substitute(model, A, b, count):
    banded_angle.substitute(A, b, count)
    for c in range(3):  # q' goes along with the tip.
        store(b, (count - 1, c), load(b, (count - 2, c)))


@inlined_by_unknowns(four=_substitute)
def substitute(model, A, b, count):
    """Replace b by the solution, in place; rows that have no equation move as the one before them."""
    banded.substitute(A, b, count, shape_of(model).reach)
