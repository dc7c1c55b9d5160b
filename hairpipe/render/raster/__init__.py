"""Rasterisation of lines, triangles and surfaces."""
