"""One strand per SIMD lane: a numba value of eight float64 that adds, multiplies and compares like one.

Strands of equal particle count are computed side by side, eight to a block; kernels are written as if for one strand,
and explicit vector instructions come out (a loop over lanes that is not vectorised costs four to eight times as much).
Arrays of strands end in an axis of WIDTH: `load` and `store` move a row of it to a register and back.

Nothing is contracted to fused multiply-adds: where the compiler would do so depends on what it inlines, and a kernel
read back from the cache would round differently from the same one just compiled. Every lane is computed alone, so a
strand's result depends neither on its lane nor on its neighbours.
"""

import operator
from collections.abc import Callable

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.extending import intrinsic, lower_builtin, lower_cast, models, register_model
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

WIDTH = 8

_VECTOR = ir.VectorType(ir.DoubleType(), WIDTH)
_BITS = ir.VectorType(ir.IntType(1), WIDTH)


class LanesType(types.Type):
    """Eight float64, one per strand."""

    def __init__(self) -> None:
        super().__init__(name="lanes")

    def can_convert_from(self, typingctx: object, other: types.Type) -> Conversion | None:
        """Let numba broadcast a number."""
        return Conversion.safe if isinstance(other, (types.Float, types.Integer)) else None


class MaskType(types.Type):
    """Eight truth values, one per strand."""

    def __init__(self) -> None:
        super().__init__(name="mask")


lanes = LanesType()
mask = MaskType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: object, fe_type: types.Type) -> None:
        super().__init__(dmm, fe_type, _VECTOR)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: object, fe_type: types.Type) -> None:
        super().__init__(dmm, fe_type, _BITS)


def _splat(builder: ir.IRBuilder, scalar: ir.Value) -> ir.Value:
    seed = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), scalar, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
    return builder.shuffle_vector(seed, ir.Constant(_VECTOR, ir.Undefined), zeros)


@lower_cast(types.Float, LanesType)
@lower_cast(types.Integer, LanesType)
def _broadcast(context, builder, fromty, toty, value):  # noqa: ANN001, ANN202
    return _splat(builder, context.cast(builder, value, fromty, types.float64))


def _is_number(t: types.Type) -> bool:
    return isinstance(t, (LanesType, types.Float, types.Integer))


def _define_operator(op: Callable, result: types.Type, emit: Callable) -> None:
    """Let op take two lanes, or lanes and a scalar, and lower it with emit(builder, a, b)."""

    class _Template(AbstractTemplate):
        def generic(self, args: tuple, kws: dict) -> object:
            if len(args) == 2 and any(isinstance(a, LanesType) for a in args) and all(map(_is_number, args)):
                return signature(result, lanes, lanes)
            return None

    infer_global(op)(_Template)
    lower_builtin(op, LanesType, LanesType)(lambda context, builder, sig, args: emit(builder, *args))


_define_operator(operator.add, lanes, lambda b, x, y: b.fadd(x, y))
_define_operator(operator.sub, lanes, lambda b, x, y: b.fsub(x, y))
_define_operator(operator.mul, lanes, lambda b, x, y: b.fmul(x, y))
_define_operator(operator.truediv, lanes, lambda b, x, y: b.fdiv(x, y))
_define_operator(operator.lt, mask, lambda b, x, y: b.fcmp_ordered("<", x, y))
_define_operator(operator.gt, mask, lambda b, x, y: b.fcmp_ordered(">", x, y))


@infer_global(operator.neg)
class _NegateTemplate(AbstractTemplate):
    def generic(self, args: tuple, kws: dict) -> object:
        return signature(lanes, lanes) if isinstance(args[0], LanesType) else None


@lower_builtin(operator.neg, LanesType)
def _negate(context, builder, sig, args):  # noqa: ANN001, ANN202
    return builder.fneg(args[0])


@intrinsic
def sqrt(typingctx, a):  # noqa: ANN001, ANN201
    """Square root of every lane."""

    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        name = f"llvm.sqrt.v{WIDTH}f64"
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_VECTOR, [_VECTOR]), name)
        return builder.call(function, args)

    return signature(lanes, lanes), emit


def _extreme(comparison: str) -> Callable:
    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        return builder.select(builder.fcmp_ordered(comparison, *args), *args)

    return emit


@intrinsic
def maximum(typingctx, a, b):  # noqa: ANN001, ANN201
    """The larger of two numbers in every lane; b where a is NaN."""
    return signature(lanes, lanes, lanes), _extreme(">")


@intrinsic
def minimum(typingctx, a, b):  # noqa: ANN001, ANN201
    """The smaller of two numbers in every lane; b where a is NaN."""
    return signature(lanes, lanes, lanes), _extreme("<")


@intrinsic
def select(typingctx, condition, a, b):  # noqa: ANN001, ANN201
    """In every lane a where the condition holds, else b."""
    return signature(lanes, mask, lanes, lanes), lambda c, builder, s, args: builder.select(*args)


@intrinsic
def either(typingctx, a, b):  # noqa: ANN001, ANN201
    """In every lane a or b."""
    return signature(mask, mask, mask), lambda c, builder, s, args: builder.or_(*args)


@intrinsic
def any_lane(typingctx, condition):  # noqa: ANN001, ANN201
    """Whether the condition holds in any lane."""

    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(WIDTH), 0))

    return signature(types.boolean, mask), emit


def _check_array(array: types.Type) -> None:
    """A row of any other array is not WIDTH numbers in a row of memory."""
    if not isinstance(array, types.Array) or array.dtype != types.float64 or array.layout != "C":
        raise TypingError(f"lanes lie in a float64 array in C order, not in {array}")


def _row_pointer(context, builder, array_type, array, index_type, index):  # noqa: ANN001, ANN202
    view = context.make_array(array_type)(context, builder, array)
    axes = zip(cgutils.unpack_tuple(builder, index), index_type, strict=True)
    position = [context.cast(builder, i, t, types.intp) for i, t in axes]
    position.append(ir.Constant(ir.IntType(64), 0))
    pointer = cgutils.get_item_pointer(context, builder, array_type, view, position, wraparound=False)
    return builder.bitcast(pointer, _VECTOR.as_pointer())


@intrinsic
def load(typingctx, array, index):  # noqa: ANN001, ANN201
    """The lanes at array[index], index a tuple of all axes but the last; the array is float64 in C order."""
    _check_array(array)

    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        pointer = _row_pointer(context, builder, sig.args[0], args[0], sig.args[1], args[1])
        return builder.load(pointer, align=8, typ=_VECTOR)

    return signature(lanes, array, index), emit


@intrinsic
def store(typingctx, array, index, value):  # noqa: ANN001, ANN201
    """Write lanes to array[index], index a tuple of all axes but the last; the array is float64 in C order."""
    _check_array(array)

    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        pointer = _row_pointer(context, builder, sig.args[0], args[0], sig.args[1], args[1])
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return signature(types.none, array, index, lanes), emit
