"""A vector of three in a SIMD register: a numba value of four float32, the last of them unused.

A kernel that follows an index list, which differs from strand to strand, cannot fill lanes with strands; it computes
the three components at once instead. Operators are those of lanes (`geometry/simd.py`).
"""
# pyright: reportCallIssue=false

from llvmlite import ir
from numba import types
from numba.core.errors import TypingError

from hairpipe.geometry.compile import intrinsic
from hairpipe.geometry.simd import LanesType

FOUR = LanesType(types.float32, 4)
WHOLE = 32767.0
"""Integer of `load_short_four` that represents 1."""
_INDEX = ir.IntType(32)


def _shuffled(builder, a, b, places):
    """Choose from the eight numbers of two vectors."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_INDEX, 4), places))


def _expect_line(array, dtype):
    if not (isinstance(array, types.Array) and array.layout == "C" and array.ndim == 1 and array.dtype == dtype):
        raise TypingError(f"expected an array of {dtype} with one axis in C order, not {array}")


def _pointer(context, builder, sig, args, vector):
    """Return where a vector begins in an array at a place, the first two arguments."""
    data = context.make_array(sig.args[0])(context, builder, args[0]).data
    begin = builder.gep(data, [context.cast(builder, args[1], sig.args[1], types.intp)], inbounds=True)
    return builder.bitcast(begin, vector.as_pointer())


@intrinsic
def zeros(typingctx):
    """Four zeros."""
    return FOUR(), lambda context, builder, sig, args: ir.Constant(FOUR.vector, [0.0] * 4)


@intrinsic
def load_four(typingctx, array, place):
    """The four numbers of float32 that begin at array[place]; the array has one axis, and is in C order."""
    _expect_line(array, types.float32)

    def emit(context, builder, sig, args):
        return builder.load(_pointer(context, builder, sig, args, FOUR.vector), align=4, typ=FOUR.vector)

    return FOUR(array, place), emit


@intrinsic
def store_four(typingctx, array, place, four):
    """Write four numbers to an array of float32, as `load_four` reads them."""
    _expect_line(array, types.float32)

    def emit(context, builder, sig, args):
        builder.store(args[2], _pointer(context, builder, sig, args, FOUR.vector), align=4)
        return context.get_dummy_value()

    return types.none(array, place, FOUR), emit


@intrinsic
def load_short_four(typingctx, array, place):
    """The four numbers of int16 that begin at array[place], over `WHOLE`; the array has one axis, and is in C order."""
    _expect_line(array, types.int16)
    kind = ir.VectorType(ir.IntType(16), 4)
    part = ir.Constant(FOUR.vector, [1.0 / WHOLE] * 4)

    def emit(context, builder, sig, args):
        parts = builder.load(_pointer(context, builder, sig, args, kind), align=2, typ=kind)
        return builder.fmul(builder.sitofp(parts, FOUR.vector), part)

    return FOUR(array, place), emit


@intrinsic
def without_first(typingctx, four):
    """The last three numbers of four: a vector, where there is nothing behind it to be loaded."""
    return FOUR(four), lambda context, builder, sig, args: _shuffled(builder, *args, *args, [1, 2, 3, 3])


@intrinsic
def item(typingctx, four, place):
    """A number of four."""

    def emit(context, builder, sig, args):
        return builder.extract_element(args[0], context.cast(builder, args[1], sig.args[1], types.int32))

    return types.float32(FOUR, place), emit


@intrinsic
def dot_in_all(typingctx, a, b):
    """The sum of all four products of two, in each of four."""

    def emit(context, builder, sig, args):
        sums = builder.fmul(*args)
        for places in ([2, 3, 0, 1], [1, 0, 3, 2]):
            sums = builder.fadd(sums, _shuffled(builder, sums, sums, places))
        return sums

    return FOUR(FOUR, FOUR), emit


@intrinsic
def last_in_all(typingctx, four):
    """The last number of four, in each of them."""
    return FOUR(four), lambda context, builder, sig, args: _shuffled(builder, *args, *args, [3, 3, 3, 3])


@intrinsic
def dot(typingctx, a, b):
    """The scalar product of two vectors."""

    def emit(context, builder, sig, args):
        products = builder.fmul(*args)
        x, y, z = (builder.extract_element(products, _INDEX(place)) for place in range(3))
        return builder.fadd(builder.fadd(x, y), z)

    return types.float32(FOUR, FOUR), emit
