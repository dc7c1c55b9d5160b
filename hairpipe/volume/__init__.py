"""Scalar fields on dense grids over hair."""
