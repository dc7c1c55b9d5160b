"""Spatial searches: bounding volume hierarchies, neighbour pairs, distances of segments and triangles; isosurfaces."""
