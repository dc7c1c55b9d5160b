"""Shading of hair, skin and scalp."""
