"""Errors of the interpolations of level sets between two frames."""
