"""Integrators compared with a converged run of the same motion."""
