"""Strands on a plate."""

from ..strand_scenes import scene, straight, triangle  # noqa: F401
