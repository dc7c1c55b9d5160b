"""One strand per SIMD lane: a numba value of eight float64, or sixteen float32, that computes and compares like one.

Strands of equal particle count are computed side by side, a vector of 64 bytes to a block; kernels are written once, as
if for one strand, and explicit vector instructions come out (a loop over lanes that is not vectorised costs four to
eight times as much). Arrays of strands end in an axis of `width(dtype)`: `load` and `store` move a row of it to a
register and back, and its dtype is that of the lanes. Numbers take the lanes' precision; lanes of both do not mix, but
rows may be kept in less precision than they are computed with (`load_as`, `store_as`).

Nothing is contracted to fused multiply-adds: where the compiler would do so depends on what it inlines, and a kernel
read back from the cache would round differently from the same one just compiled. Every lane is computed alone, so a
strand's result depends neither on its lane nor on its neighbours. Arrays of lanes are combined row by row: in a kernel,
numpy's own expressions leave single precision and take ten times as long to compile.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, prange, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.extending import lower_builtin, lower_cast, models, register_model
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np.arrayobj import populate_array
from numpy.typing import DTypeLike

from hairpipe.geometry.compile import inlined, intrinsic

VECTOR_BYTES = 64


def width(dtype: DTypeLike) -> int:
    """Number of lanes of a dtype."""
    return VECTOR_BYTES // np.dtype(dtype).itemsize


WIDTH = width(np.float64)


class LanesType(types.Type):
    """Floating-point numbers of one dtype, one per strand; or so many."""

    def __init__(self, dtype: types.Float, count: int = 0) -> None:
        self.dtype = dtype
        self.width = count or VECTOR_BYTES * 8 // dtype.bitwidth
        number = ir.DoubleType() if dtype == types.float64 else ir.FloatType()
        self.vector = ir.VectorType(number, self.width)
        super().__init__(name=f"lanes({dtype}, {self.width})")

    def can_convert_from(self, typingctx: object, other: types.Type) -> Conversion | None:
        """Let numba broadcast a number."""
        return Conversion.safe if isinstance(other, (types.Float, types.Integer)) else None


class MaskType(types.Type):
    """Truth values, one per strand, from comparing lanes of a type."""

    def __init__(self, lanes: LanesType) -> None:
        self.lanes = lanes
        super().__init__(name=f"mask({lanes.dtype}, {lanes.width})")


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: object, fe_type: LanesType) -> None:
        super().__init__(dmm, fe_type, fe_type.vector)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: object, fe_type: MaskType) -> None:
        super().__init__(dmm, fe_type, ir.VectorType(ir.IntType(1), fe_type.lanes.width))


@lower_cast(types.Float, LanesType)
@lower_cast(types.Integer, LanesType)
def _broadcast(context, builder, fromty, toty, value):
    number = context.cast(builder, value, fromty, toty.dtype)
    nothing = ir.Constant(toty.vector, ir.Undefined)
    seed = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), toty.width), [0] * toty.width)
    return builder.shuffle_vector(seed, nothing, zeros)


def _common(*args: types.Type) -> LanesType | None:
    """Return the one type of lanes among lanes and numbers."""
    kinds = {a for a in args if isinstance(a, LanesType)}
    numbers = all(isinstance(a, (LanesType, types.Float, types.Integer)) for a in args)
    return kinds.pop() if numbers and len(kinds) == 1 else None


_infer: Any = infer_global  # declared to return None


def _define_operator(op: Callable, result: Callable[[LanesType], types.Type], emit: Callable) -> None:
    """Let op take two lanes, or lanes and a number, and lower it with emit(builder, a, b)."""

    class _Template(AbstractTemplate):
        def generic(self, args: tuple, kws: dict) -> object:
            lanes = _common(*args) if len(args) == 2 else None
            return signature(result(lanes), lanes, lanes) if lanes else None

    _infer(op)(_Template)
    lower_builtin(op, LanesType, LanesType)(lambda context, builder, sig, args: emit(builder, *args))


for _op, _emit in (
    (operator.add, lambda b, x, y: b.fadd(x, y)),
    (operator.sub, lambda b, x, y: b.fsub(x, y)),
    (operator.mul, lambda b, x, y: b.fmul(x, y)),
    (operator.truediv, lambda b, x, y: b.fdiv(x, y)),
):
    _define_operator(_op, lambda lanes: lanes, _emit)
_define_operator(operator.lt, MaskType, lambda b, x, y: b.fcmp_ordered("<", x, y))
_define_operator(operator.gt, MaskType, lambda b, x, y: b.fcmp_ordered(">", x, y))
_define_operator(operator.le, MaskType, lambda b, x, y: b.fcmp_ordered("<=", x, y))


@_infer(operator.neg)
class _NegateTemplate(AbstractTemplate):
    def generic(self, args: tuple, kws: dict) -> object:
        return signature(args[0], args[0]) if isinstance(args[0], LanesType) else None


@lower_builtin(operator.neg, LanesType)
def _negate(context, builder, sig, args):
    return builder.fneg(args[0])


def _refusal(wanted: str, *args: types.Type) -> TypingError:
    return TypingError(f"expected {wanted}, not {', '.join(map(str, args))}")


def _expect_common(*args: types.Type) -> LanesType:
    lanes = _common(*args)
    if lanes is None:
        raise _refusal("lanes of one type, or lanes and numbers", *args)
    return lanes


def _expect_masks(*args: types.Type) -> LanesType:
    if not isinstance(args[0], MaskType) or any(a != args[0] for a in args):
        raise _refusal("masks of one type", *args)
    return args[0].lanes


def _llvm(builder, name, lanes, arguments):
    """Return LLVM's function of this name, from so many lanes to lanes."""
    kind = ir.FunctionType(lanes.vector, [lanes.vector] * arguments)
    return cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{lanes.width}f{lanes.dtype.bitwidth}")


@intrinsic
def sqrt(typingctx, a):
    """Square root of every lane."""
    lanes = _expect_common(a)
    return signature(lanes, lanes), lambda c, builder, s, args: builder.call(_llvm(builder, "sqrt", lanes, 1), args)


@intrinsic
def multiply_add(typingctx, a, b, c):
    """Compute a b + c in every lane, rounded once."""
    lanes = _expect_common(a, b, c)
    return signature(*[lanes] * 4), lambda c, builder, s, args: builder.call(_llvm(builder, "fma", lanes, 3), args)


@intrinsic
def by_precision(typingctx, like, double, single):
    """One of two numbers, by the precision of lanes."""
    place = 1 if _expect_common(like).dtype == types.float64 else 2
    return signature(types.float64, like, types.float64, types.float64), lambda c, builder, s, args: args[place]


@intrinsic
def lane(typingctx, number):
    """A number as the only lane of a value."""
    lanes = LanesType(types.float64, 1)
    return signature(lanes, types.float64), lambda c, builder, s, args: builder.bitcast(args[0], lanes.vector)


@intrinsic
def number(typingctx, lane):
    """The only lane of a value as a number."""
    return signature(types.float64, _expect_common(lane)), lambda c, b, s, args: b.bitcast(args[0], ir.DoubleType())


def _extreme(comparison: str) -> Callable:
    def emit(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered(comparison, *args), *args)

    return emit


@intrinsic
def maximum(typingctx, a, b):
    """The larger of two numbers in every lane; b where a is NaN."""
    lanes = _expect_common(a, b)
    return signature(lanes, lanes, lanes), _extreme(">")


@intrinsic
def minimum(typingctx, a, b):
    """The smaller of two numbers in every lane; b where a is NaN."""
    lanes = _expect_common(a, b)
    return signature(lanes, lanes, lanes), _extreme("<")


@intrinsic
def select(typingctx, condition, a, b):
    """In every lane a where the condition holds, else b; a and b may be numbers."""
    lanes = _expect_common(_expect_masks(condition), a, b)
    return signature(lanes, condition, lanes, lanes), lambda c, builder, s, args: builder.select(*args)


@intrinsic
def either(typingctx, a, b):
    """In every lane a or b."""
    _expect_masks(a, b)
    return signature(a, a, a), lambda c, builder, s, args: builder.or_(*args)


@intrinsic
def both(typingctx, a, b):
    """In every lane a and b."""
    _expect_masks(a, b)
    return signature(a, a, a), lambda c, builder, s, args: builder.and_(*args)


@intrinsic
def any_lane(typingctx, condition):
    """Whether the condition holds in any lane."""
    bits = ir.IntType(_expect_masks(condition).width)

    def emit(context, builder, sig, args):
        return builder.icmp_unsigned("!=", builder.bitcast(args[0], bits), ir.Constant(bits, 0))

    return signature(types.boolean, condition), emit


@intrinsic
def bits(typingctx, condition):
    """The lanes in which the condition holds, as the bits of an int64, the first lane lowest."""
    lanes = ir.IntType(_expect_masks(condition).width)

    def emit(context, builder, sig, args):
        return builder.zext(builder.bitcast(args[0], lanes), ir.IntType(64))

    return signature(types.int64, condition), emit


@intrinsic
def lowest(typingctx, a):
    """The place of the lowest bit that is set in an int64 other than 0."""
    if a != types.int64:
        raise _refusal("an int64", a)
    nowhere = ir.Constant(ir.IntType(1), 1)
    return signature(a, a), lambda c, builder, s, args: builder.cttz(args[0], nowhere)


def _lanes_of(array: types.Type) -> LanesType:
    """Return the lanes that lie in an array; a row of one not in C order is not contiguous."""
    if isinstance(array, types.Array) and array.layout == "C" and isinstance(array.dtype, types.Float):
        return LanesType(array.dtype)
    raise _refusal("an array of float32 or float64 in C order", array)


def _row_pointer(context, builder, sig, args, vector):
    """Return where a row of an array begins, the first two arguments, as a pointer to a vector."""
    view = context.make_array(sig.args[0])(context, builder, args[0])
    axes = zip(cgutils.unpack_tuple(builder, args[1]), sig.args[1], strict=True)
    position = [context.cast(builder, i, t, types.intp) for i, t in axes]
    row = position[0]
    # The last axis is known to be a vector long: said in constants, neighbouring rows cost no arithmetic.
    for i, length in zip(position[1:], cgutils.unpack_tuple(builder, view.shape)[1:-1], strict=True):
        row = builder.add(builder.mul(row, length, flags=["nsw"]), i, flags=["nsw"])
    return builder.gep(builder.bitcast(view.data, vector.as_pointer()), [row], inbounds=True, source_etype=vector)


def _reads(kept: LanesType, lanes: LanesType) -> Callable:
    """Read a row that is kept in one precision as lanes of that or another."""
    vector = ir.VectorType(kept.vector.element, lanes.width)

    def emit(context, builder, sig, args):
        pointer = _row_pointer(context, builder, sig, args, vector)
        return _convert(builder, builder.load(pointer, align=kept.dtype.bitwidth // 8, typ=vector), kept, lanes)

    return emit


def _writes(lanes: LanesType, kept: LanesType) -> Callable:
    """Write lanes, the last argument, to a row that is kept in their precision or another."""
    vector = ir.VectorType(kept.vector.element, lanes.width)

    def emit(context, builder, sig, args):
        pointer = _row_pointer(context, builder, sig, args, vector)
        builder.store(_convert(builder, args[2], lanes, kept), pointer, align=kept.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return emit


def _convert(builder, value, before, after):
    """Change the precision of a vector from that of one type of lanes to that of another."""
    if before.dtype == after.dtype:
        return value
    kind = ir.VectorType(after.vector.element, value.type.count)
    widens = after.dtype.bitwidth > before.dtype.bitwidth
    return builder.fpext(value, kind) if widens else builder.fptrunc(value, kind)


@intrinsic
def load(typingctx, array, index):
    """The lanes at array[index], index a tuple of all axes but the last; the array is in C order."""
    lanes = _lanes_of(array)
    return signature(lanes, array, index), _reads(lanes, lanes)


@intrinsic
def load_as(typingctx, array, index, like):
    """The row at array[index], which is as long as the lanes like and may be of another precision, as such lanes."""
    lanes = _expect_common(like)
    return signature(lanes, array, index, lanes), _reads(_lanes_of(array), lanes)


@intrinsic
def store(typingctx, array, index, value):
    """Write lanes, or a number to all of them, to array[index], index a tuple of all axes but the last."""
    lanes = _expect_common(_lanes_of(array), value)
    return signature(types.none, array, index, lanes), _writes(lanes, lanes)


@intrinsic
def store_as(typingctx, array, index, value):
    """Write lanes to array[index], a row as long as they are, in its precision."""
    lanes = _expect_common(value)
    return signature(types.none, array, index, lanes), _writes(lanes, _lanes_of(array))


@intrinsic(prefer_literal=True)
def local_rows(typingctx, count, like):
    """So many rows of lanes, (count, W), like those of an array, on the stack of the function that asks: uninitialised.

    A kernel without reference counts makes no other arrays. They end with the function.
    """
    lanes = _lanes_of(like)
    if not isinstance(count, types.IntegerLiteral):
        raise _refusal("a constant number of rows", count)
    rows = count.literal_value
    size = lanes.dtype.bitwidth // 8
    kind = types.Array(lanes.dtype, 2, "C")

    def emit(context, builder, sig, args):
        view = context.make_array(kind)(context, builder)
        memory = cgutils.alloca_once(builder, ir.ArrayType(lanes.vector, rows))
        pointer = builder.bitcast(memory, view.data.type)
        itemsize = context.get_constant(types.intp, size)
        numbers = {
            name: cgutils.pack_array(builder, [context.get_constant(types.intp, n) for n in of])
            for name, of in (("shape", (rows, lanes.width)), ("strides", (lanes.width * size, size)))
        }
        populate_array(view, data=pointer, **numbers, itemsize=itemsize, meminfo=None)
        return view._getvalue()

    return signature(kind, count, like), emit


@inlined
def difference(x, p, q):
    """Return the vector of lanes x_q - x_p from an array x (rows, 3, W)."""
    return load(x, (q, 0)) - load(x, (p, 0)), load(x, (q, 1)) - load(x, (p, 1)), load(x, (q, 2)) - load(x, (p, 2))


@inlined
def fill(out, value):
    """Set all of out, (particles, components, W), to a number, in place."""
    for p in range(out.shape[0]):
        for c in range(out.shape[1]):
            store(out, (p, c), value)


@inlined
def copy(out, x):
    """Set out to x, in place; both (particles, components, W)."""
    for p in range(out.shape[0]):
        for c in range(out.shape[1]):
            store(out, (p, c), load(x, (p, c)))


def copied(x: np.ndarray) -> np.ndarray:
    """Copy x, (rows, components, W), in parallel."""
    out = np.empty_like(x)
    _copy_all(out, x)
    return out


@njit(cache=True, parallel=True)
def _copy_all(out, x):
    for p in prange(out.shape[0]):
        for c in range(out.shape[1]):
            store(out, (p, c), load(x, (p, c)))


@njit(cache=True, parallel=True)
def combine_all(out, a, x, b, y):
    """Set out, which may be x or y, to a x + b y, in place; a and b numbers, the others (rows, components, W)."""
    for p in prange(out.shape[0]):  # Rows are independent, so that out may be x or y.
        for c in range(out.shape[1]):
            store(out, (p, c), a * load(x, (p, c)) + b * load(y, (p, c)))
