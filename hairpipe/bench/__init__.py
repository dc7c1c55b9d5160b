"""Benchmarks: times, limits of the machine, and machine code."""
