"""Compile options of small functions that kernels call millions of times.

Records (NamedTuples) of arrays may be arguments of any kernel. But in a loop over `prange` numba drops what its body
writes to an array that is a member of a tuple, without a warning: such arrays are arguments of their own there, or an
inlined function writes to them.

A parallel call costs a wake-up of every thread: small scenes compute on few.

Prefetch instructions: memory is requested ahead of its use, so that kernels that follow index lists do not stall.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Any

from llvmlite import ir
from numba import get_num_threads, njit, set_num_threads, types
from numba.core import extending
from numba.core.registry import CPUDispatcher

intrinsic: Any = extending.intrinsic  # To a type checker its functions take a typing context, which nobody passes.

# Numba counts references to every array a function touches, atomically, and calls rather than inlines: 80 ns for a
# trilinear sample of which the reads take 10, more with two threads. These functions create and keep no array: they
# are compiled without reference counts (`_nrt`), and inlined into the loop that calls them.
_OPTIONS = {"error_model": "numpy", "_nrt": False}


class Inlined(CPUDispatcher):
    """A function for kernels alone, which is compiled without the entries for Python and for C, which are never called.

    Numba compiles a function once for every literal that it is called with. Here a literal counts as any number of its
    type: LLVM sees the constant anyway, when it inlines the function.
    """

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Compile it for the types of a call in a kernel."""
        plain = {name: types.unliteral(kind) for name, kind in kws.items()}
        return super().get_call_template([types.unliteral(kind) for kind in args], plain)

    @cached_property
    def _entered(self) -> Callable:
        return njit(**_OPTIONS)(self.py_func)

    def __call__(self, *args: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Call it from Python, as tests do: compiled again in each process, with the entry."""
        return self._entered(*args)


def inlined(function: Callable) -> Inlined:
    """Decorate a function that kernels inline."""
    entries = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    kernel = Inlined(function, targetoptions=_OPTIONS | entries | {"nopython": True, "forceinline": True})
    kernel.enable_caching()
    return kernel


POINTS_A_THREAD = 6_000
"""Points of hair from which a further thread pays: `hairpipe bench busy`, with other values of it."""


@contextmanager
def threads_for(points: int) -> Iterator[None]:
    """Compute on no more threads than so many points keep busy; no result depends on their number."""
    most = get_num_threads()
    set_num_threads(min(most, 1 + points // POINTS_A_THREAD))
    try:
        yield
    finally:
        set_num_threads(most)


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
