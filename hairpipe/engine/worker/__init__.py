"""A process that evaluates nodes: its kernels, how it compiles and runs them on threads."""
