"""Animated meshes: samples of points over time, of any format, read as a mesh at one instant."""
