"""Scenes of segments, and rods."""

from ...segment_scenes import few_hairs, hair, scene  # noqa: F401
