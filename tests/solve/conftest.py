"""Strands that are coupled anywhere."""

from ..contact.coupled_strands import dense, offsets, random_couplings  # noqa: F401
from ..strand_scenes import scene, straight, triangle  # noqa: F401
