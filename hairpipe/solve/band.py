"""Kernels for the banded matrix of a strand, selected by the number of unknowns per row of its model.

Three unknowns a row are `geometry/banded.py`, four are `geometry/banded_angle.py`. Numba selects one at compilation by
the type of the model, as for the functions of `interface.py`.
"""

from collections.abc import Callable
from typing import Any

from hairpipe.geometry import banded, banded_angle
from hairpipe.geometry.banded import add, clear_row
from hairpipe.geometry.banded import row_size as size_by_reach
from hairpipe.geometry.compile import inlined
from hairpipe.geometry.simd import load, store
from hairpipe.strands.interface import ModelKind, by_model, for_models
from hairpipe.strands.layout import Shape


@inlined
def row_size(shape: Shape) -> int:
    """Numbers in a row of the matrix."""
    return size_by_reach(shape.reach) if shape.unknowns == 3 else banded_angle.SIZE


@by_model
def start_row(model: Any, A: Any, p: Any, count: Any) -> Any:
    """Clear row p of a strand of so many rows, in place: zero, and 1 on the diagonal where there is no equation."""


@by_model
def add_inertia(model: Any, A: Any, p: Any, inertia: Any) -> Any:
    """Add a mass to the position of row p, in lanes, in place."""


@by_model
def add_point(model: Any, A: Any, p: Any, block: Any) -> Any:
    """Add a symmetric block, a tuple of six lanes, to the position of row p, in place."""


@by_model
def add_next(model: Any, A: Any, p: Any, block: Any) -> Any:
    """Add a symmetric block, six lanes, between the positions of row p and the next on the axis, in place."""


@by_model
def fix_root(model: Any, A: Any, b: Any, p: Any, count: Any, lowest: Any) -> Any:
    """Hold row p at the root, in place; return the lowest pivots of this and before."""


@by_model
def fix_lanes(model: Any, A: Any, b: Any, p: Any, fixed: Any) -> Any:
    """Hold row p in the lanes of a mask, in place."""


@by_model
def eliminate(model: Any, A: Any, b: Any, p: Any, count: Any, lowest: Any) -> Any:
    """Eliminate row p, in place; return the lowest pivots of this and before, where they may be negative."""


@by_model
def forward(model: Any, A: Any, b: Any, p: Any, count: Any) -> Any:
    """Eliminate row p from another right-hand side, as `eliminate`, in place."""


@by_model
def substitute(model: Any, A: Any, b: Any, count: Any) -> Any:
    """Replace b by the solution, in place; rows that have no equation move as the one before them."""


@inlined
def _start_row4(A, p, count):
    clear_row(A, p)
    if p == count - 1:  # The last row is that of q', which has no equation: an identity keeps the elimination regular.
        _add_inertia(A, p, (0, 11, 21), 1.0 + 0.0 * load(A, (p, 0)))
    if p >= count - 2:  # No edge begins at the last two rows: their angles have no equation either.
        store(A, (p, 30), 1.0)


@inlined
def _add_inertia(A, p, places, inertia):
    add(A, p, places[0], inertia)
    add(A, p, places[1], inertia)
    add(A, p, places[2], inertia)


@inlined
def _add_next4(A, p, block):
    xx, xy, xz, yy, yz, zz = block
    for row, three in ((4, (xx, xy, xz)), (14, (xy, yy, yz)), (23, (xz, yz, zz))):
        add(A, p, row, three[0])
        add(A, p, row + 1, three[1])
        add(A, p, row + 2, three[2])


@inlined
def _fix_root4(A, b, p, count, lowest, root):
    """Only the angle of the root's own edge is free."""
    if p < root:
        banded_angle.fix_row(A, b, p)
        return lowest
    banded_angle.fix_position(A, b, p)
    return banded_angle.eliminate(A, b, p, count, lowest)


@inlined
def _substitute4(A, b, count):
    banded_angle.substitute(A, b, count)
    for c in range(3):  # q' goes along with the tip.
        store(b, (count - 1, c), load(b, (count - 2, c)))


@for_models(start_row)
def _start_row(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        return lambda model, A, p, count: clear_row(A, p)
    return lambda model, A, p, count: _start_row4(A, p, count)


@for_models(add_inertia)
def _add_mass(kind: ModelKind) -> Callable:
    shape = kind.shape
    places = (0, 3, 5) if shape.unknowns == 3 else (0, 11, 21)
    return lambda model, A, p, inertia: _add_inertia(A, p, places, inertia)


@for_models(add_point)
def _add_point(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        return lambda model, A, p, block: banded.add_diagonal(A, p, *block)
    return lambda model, A, p, block: banded_angle.add_point(A, p, block)


@for_models(add_next)
def _add_next(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        stride = shape.stride
        return lambda model, A, p, block: banded.add_coupling(A, p, stride, block)
    return lambda model, A, p, block: _add_next4(A, p, block)


@for_models(fix_root)
def _fix_root(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        return lambda model, A, b, p, count, lowest: _fix_root3(A, b, p, lowest)
    root = shape.clamped - 1
    return lambda model, A, b, p, count, lowest: _fix_root4(A, b, p, count, lowest, root)


@inlined
def _fix_root3(A, b, p, lowest):
    banded.fix_row(A, b, p)
    return lowest


@for_models(fix_lanes)
def _fix_lanes(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        return lambda model, A, b, p, fixed: banded.fix_lanes(A, b, p, fixed)
    return lambda model, A, b, p, fixed: banded_angle.fix_lanes(A, b, p, fixed)


@inlined
def _eliminate3(A, b, p, count, reach, lowest):
    banded.eliminate(A, b, p, count, reach)
    return lowest


@for_models(eliminate)
def _eliminate(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        reach = shape.reach
        return lambda model, A, b, p, count, lowest: _eliminate3(A, b, p, count, reach, lowest)
    return lambda model, A, b, p, count, lowest: banded_angle.eliminate(A, b, p, count, lowest)


@for_models(forward)
def _forward(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        reach = shape.reach
        return lambda model, A, b, p, count: banded.forward(A, b, p, count, reach)
    return lambda model, A, b, p, count: banded_angle.forward(A, b, p, count)


@for_models(substitute)
def _substitute(kind: ModelKind) -> Callable:
    shape = kind.shape
    if shape.unknowns == 3:
        reach = shape.reach
        return lambda model, A, b, count: banded.substitute(A, b, count, reach)
    return lambda model, A, b, count: _substitute4(A, b, count)
