"""Vectors, SIMD lanes, trees over segments and triangles, pairs, distances."""
