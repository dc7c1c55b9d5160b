"""Whether a kernel computes in vectors: its machine code, instruction by instruction."""

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from numba import typeof
from numba.core.dispatcher import Dispatcher

_ARITHMETIC = re.compile(r"\s*v?(?:add|sub|mul|div|sqrt|max|min|fn?m(?:add|sub)\d*)([ps])[sd]\s.*?(%[xyz]mm)")


class Arithmetic(NamedTuple):
    """Instructions of floating-point arithmetic in machine code.

    zmm, ymm, xmm  on vectors of 64, 32 and 16 bytes
    scalar         on one number
    """

    zmm: int
    ymm: int
    xmm: int
    scalar: int

    @property
    def packed(self) -> float:
        """Share of the instructions that compute on vectors."""
        return 1.0 - self.scalar / max(1, sum(self))


def count_arithmetic(lines: Iterable[str]) -> Arithmetic:
    """Count the additions, multiplications, divisions, roots and extremes in assembly of x86-64, AT&T syntax."""
    found = [match.groups() for match in map(_ARITHMETIC.match, lines) if match]
    packed = [register for kind, register in found if kind == "p"]
    zmm, ymm, xmm = (packed.count(register) for register in ("%zmm", "%ymm", "%xmm"))
    return Arithmetic(zmm, ymm, xmm, len(found) - len(packed))


def assembly_of(kernel: Dispatcher, *args: Any) -> str:
    """Return the machine code of a kernel, with all that is copied into it, for arguments like these.

    A kernel that is in the cache is read from there, not compiled again.
    """
    signature = tuple(map(typeof, args))
    kernel.compile(signature)
    library: Any = kernel.overloads[signature].library
    # Numba shows no assembly of what it read back, but keeps its optimised form, to which only this step is left.
    return str(library.codegen._tm.emit_assembly(library._get_module_for_linking()))
