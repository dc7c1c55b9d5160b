"""Corrections of positions and velocities between solves, without forces."""
