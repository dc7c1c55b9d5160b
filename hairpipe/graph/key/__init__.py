"""Digests of the code that results depend on."""
