"""Strands at rest under gravity: settled, or held in the shape of the groom."""
