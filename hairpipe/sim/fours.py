"""A vector of space in a register: a numba value of four float32, of which the last is nobody's.

Where kernels follow lists, which differ from strand to strand, there are no lanes to fill; three components, then, are
what can be computed at once. They add and multiply as lanes do (`sim/lanes.py`).
"""

from llvmlite import ir
from numba import types
from numba.core.errors import TypingError
from numba.core.extending import intrinsic

from hairpipe.sim.lanes import LanesType

FOUR = LanesType(types.float32, 4)
_INDEX = ir.IntType(32)


def _shuffled(builder, a, b, places):  # noqa: ANN001, ANN202
    """Choose from the eight numbers of two vectors."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INDEX, 4), places))


@intrinsic
def zeros(typingctx):  # noqa: ANN001, ANN201
    """Four zeros."""
    return FOUR(), lambda context, builder, sig, args: ir.Constant(FOUR.vector, [0.0] * 4)


@intrinsic
def load_four(typingctx, array, place):  # noqa: ANN001, ANN201
    """The four numbers of float32 that begin at array[place]; the array has one axis, and is in C order."""
    if not (
        isinstance(array, types.Array) and array.layout == "C" and array.ndim == 1 and array.dtype == types.float32
    ):
        raise TypingError(f"expected an array of float32 with one axis in C order, not {array}")

    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        pointer = builder.gep(data, [context.cast(builder, args[1], sig.args[1], types.intp)], inbounds=True)
        return builder.load(builder.bitcast(pointer, FOUR.vector.as_pointer()), align=4, typ=FOUR.vector)

    return FOUR(array, place), emit


@intrinsic
def without_first(typingctx, four):  # noqa: ANN001, ANN201
    """The last three numbers of four: a vector, where there is nothing behind it to be loaded."""
    return FOUR(four), lambda context, builder, sig, args: _shuffled(builder, *args, *args, [1, 2, 3, 3])


@intrinsic
def item(typingctx, four, place):  # noqa: ANN001, ANN201
    """A number of four."""

    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        return builder.extract_element(args[0], context.cast(builder, args[1], sig.args[1], types.int32))

    return types.float32(FOUR, place), emit


@intrinsic
def symmetric_times(typingctx, low, high, vector):  # noqa: ANN001, ANN201
    """M v for a symmetric M that is given as xx xy xz and a number, yy yz zz and a number."""

    def emit(context, builder, sig, args):  # noqa: ANN001, ANN202
        low, high, v = args
        second, third = _shuffled(builder, low, high, [1, 4, 5, 5]), _shuffled(builder, low, high, [2, 5, 6, 6])
        total = builder.fmul(low, _shuffled(builder, v, v, [0] * 4))
        for column, place in ((second, 1), (third, 2)):
            total = builder.fadd(total, builder.fmul(column, _shuffled(builder, v, v, [place] * 4)))
        return total

    return FOUR(FOUR, FOUR, FOUR), emit
