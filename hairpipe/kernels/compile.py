"""How functions are compiled that read a few numbers from large arrays, millions of times."""

from numba import njit

# Numba counts references to every array a function touches, atomically, and calls rather than inlines: 80 ns for a
# trilinear sample of which the reading takes 10, more with two threads. These functions make no array and keep none, so
# they count none (`_nrt`), and are copied into the loop that calls them.
inlined = njit(cache=True, forceinline=True, error_model="numpy", _nrt=False)
