"""Work of a kernel: its own source, run by Python on lanes that count their operations.

Every kernel it calls is replaced by its source, every operation on lanes by numpy's. Numbers that are the same for all
strands cost one strand nothing and are not counted.
"""

from collections.abc import Callable
from types import CellType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np
from numba.core.dispatcher import Dispatcher

from hairpipe.geometry import simd
from hairpipe.strands.interface import ByModel

_COUNTED = {np.add, np.subtract, np.multiply, np.divide, np.sqrt}


class Work(NamedTuple):
    """What one strand costs.

    operations  additions, multiplications, divisions and roots
    bytes       of the arrays that were handed in: each counts once if it is read, and once if it is written
    """

    operations: float
    bytes: float

    def per(self, count: int) -> "Work":
        """Divide among so many particles."""
        return Work(self.operations / count, self.bytes / count)


class _Tally:
    """Counts, and the addresses of the rows that were moved."""

    def __init__(self, arrays: list[np.ndarray]) -> None:
        self.operations = 0
        self.moved: dict[tuple[str, int], int] = {}
        self._ranges = [(a.ctypes.data, a.ctypes.data + a.nbytes) for a in arrays]

    def move(self, how: str, row: np.ndarray) -> None:
        """Note a row, unless the kernel made the array itself."""
        address = row.ctypes.data
        known = ("written", address) in self.moved  # a row that was written is not read from afar
        if not known and any(begin <= address < end for begin, end in self._ranges):
            self.moved[how, address] = row.itemsize


def count_work(kernel: Dispatcher, *args: Any) -> Work:
    """Run a kernel on its arguments, in place as it does, and count."""
    tally = _Tally(
        [a for arg in args for a in (arg if isinstance(arg, tuple) else (arg,)) if isinstance(a, np.ndarray)]
    )

    class _Lanes(np.ndarray):
        def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
            tally.operations += ufunc in _COUNTED
            plain = [np.asarray(i) if isinstance(i, np.ndarray) else i for i in inputs]
            return np.asarray(ufunc(*plain, **kwargs)).view(_Lanes)

    def load(array: np.ndarray, index: tuple[int, ...]) -> np.ndarray:
        tally.move("read", array[index])
        return array[index].copy().view(_Lanes)

    def store(array: np.ndarray, index: tuple[int, ...], value: Any) -> None:
        tally.move("written", array[index])
        array[index] = value

    in_python = {
        simd.load: load,
        simd.load_as: lambda array, index, like: load(array, index),
        simd.store: store,
        simd.by_precision: lambda like, double, single: double if like.dtype == np.float64 else single,
        simd.sqrt: np.sqrt,
        simd.maximum: np.maximum,
        simd.minimum: np.minimum,
        simd.multiply_add: lambda a, b, c: a * b + c,
        simd.select: lambda condition, a, b: np.where(condition, a, b).view(_Lanes),
        simd.both: np.logical_and,
        simd.either: np.logical_or,
        simd.any_lane: lambda condition: bool(np.asarray(condition).any()),
    }
    _in_python(kernel, in_python)(*args)
    return Work(tally.operations, sum(tally.moved.values()))


def _in_python(thing: Any, known: dict[Any, Callable]) -> Any:
    """Return a kernel as Python that calls no machine code."""
    if thing not in known:
        if isinstance(thing, ModuleType):
            return _Module(thing, known)
        if not isinstance(thing, Dispatcher):
            return _choose(thing, known)
        known[thing] = lambda *args: known[thing](*args)  # It may have the name of a function of a module it calls.
        known[thing] = _with_globals(thing.py_func, known)
    return known[thing]


def _with_globals(function: FunctionType, known: dict[Any, Callable]) -> Callable:
    """Copy a function of Python, and put what runs in Python in place of what it calls."""
    names = {name: value for name, value in function.__globals__.items() if name in function.__code__.co_names}
    ours = {name: _in_python(value, known) for name, value in names.items() if _is_ours(value)}
    scope = function.__globals__ | ours
    cells = (cell.cell_contents for cell in function.__closure__ or ())
    closure = tuple(CellType(_in_python(value, known) if _is_ours(value) else value) for value in cells)
    return FunctionType(function.__code__, scope, closure=closure)


def _is_ours(thing: Any) -> bool:
    """Whether something is a kernel, an operation on lanes, or a name that numba gives a kernel by type."""
    if isinstance(thing, ModuleType):
        return thing.__name__.startswith("hairpipe.")
    return callable(thing) and (isinstance(thing, (Dispatcher, ByModel)) or thing in vars(simd).values())


class _Module:
    """A module of ours, its kernels as Python."""

    def __init__(self, module: ModuleType, known: dict[Any, Callable]) -> None:
        self._module, self._known = module, known

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._module, name)
        return _in_python(value, self._known) if _is_ours(value) else value


def _choose(thing: ByModel, known: dict[Any, Callable]) -> Callable:
    """Call the kernel that numba would choose by the type of the first argument."""
    return lambda *args: _in_python(thing.kernel_of(type(args[0])), known)(*args)
