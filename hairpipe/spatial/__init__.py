"""Spatial searches: bounding volume hierarchies, neighbour pairs, and distances of segments and triangles."""
