"""Scenes of segments, and rods."""

from ...segment_scenes import brute, few_hairs, hair, scene  # noqa: F401
