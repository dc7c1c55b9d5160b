"""Strands that are coupled anywhere."""

from ..contact.coupled_strands import dense, offsets, random_couplings  # noqa: F401
