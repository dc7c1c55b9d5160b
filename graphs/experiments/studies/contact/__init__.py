"""Convergence and failures of the solvers of contact between hairs."""
