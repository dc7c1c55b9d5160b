"""Baking, sampling and interpolating level sets in time."""
