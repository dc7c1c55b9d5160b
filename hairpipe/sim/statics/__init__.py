"""Strands at rest under gravity."""
