"""Stages, time integrators, conjugate gradients, banded systems, step sizes, lost steps."""
