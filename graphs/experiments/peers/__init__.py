"""Solvers of others beside ours: each adapter lays the same strands in one solver; none is needed by anything else."""
