"""Prefetch instructions: memory is requested ahead of its use, so that kernels that follow index lists do not stall."""

from llvmlite import ir
from numba import types
from numba.core.extending import intrinsic

AHEAD = 48
"""Number of entries of a list by which prefetching is ahead of computation."""
_NUMBER = ir.IntType(32)
_READ, _ALL_CACHES, _DATA = _NUMBER(0), _NUMBER(3), _NUMBER(1)


@intrinsic
def fetch(typingctx, array, row):
    """Prefetch the first number of array[row] into all caches."""

    def emit(context, builder, sig, args):
        lists = context.make_array(sig.args[0])(context, builder, args[0])
        bytes_a_row = builder.extract_value(lists.strides, 0)
        row = context.cast(builder, args[1], sig.args[1], types.intp)
        address = builder.add(builder.ptrtoint(lists.data, bytes_a_row.type), builder.mul(row, bytes_a_row))
        byte = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [byte, _NUMBER, _NUMBER, _NUMBER])
        prefetch = builder.module.declare_intrinsic("llvm.prefetch", [byte], kind)
        builder.call(prefetch, [builder.inttoptr(address, byte), _READ, _ALL_CACHES, _DATA])
        return context.get_dummy_value()

    return types.void(array, row), emit
