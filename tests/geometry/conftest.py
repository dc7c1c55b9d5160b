"""Scenes of segments, for what searches them."""

from ..segment_scenes import few_hairs, hair, scene  # noqa: F401
