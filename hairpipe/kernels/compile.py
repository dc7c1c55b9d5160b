"""Compile options of small functions that kernels call millions of times.

Records (NamedTuples) of arrays may be arguments of any kernel. But in a loop over `prange` numba drops what its body
writes to an array that is a member of a tuple, without a warning: such arrays are arguments of their own there, or an
inlined function writes to them.
"""

from numba import njit

# Numba counts references to every array a function touches, atomically, and calls rather than inlines: 80 ns for a
# trilinear sample of which the reads take 10, more with two threads. These functions create and keep no array: they
# are compiled without reference counts (`_nrt`), and inlined into the loop that calls them.
inlined = njit(cache=True, forceinline=True, error_model="numpy", _nrt=False)
