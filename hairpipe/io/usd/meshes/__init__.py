"""Meshes of a stage: triangles, skeletons, bodies at rest, and animated meshes."""
