"""Building blocks of kernels: SIMD lanes, small vectors, banded systems."""
