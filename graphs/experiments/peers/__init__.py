"""Solvers of others and ours: each adapter lays the same strands in one solver; nothing else needs them."""
