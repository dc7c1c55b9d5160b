"""Rods and their pairs, and strands that are coupled anywhere."""

from ..strand_scenes import scene, straight, triangle  # noqa: F401
from .coupled_strands import dense, offsets, random_couplings  # noqa: F401
from .rod_scenes import cross, jacobian_of, rods  # noqa: F401
