"""Arithmetic of kernels: what they are written to do, and what their machine code does."""
