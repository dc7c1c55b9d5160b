"""What compiled code is written in: SIMD lanes, small vectors, banded systems. It knows no hair."""
