"""Seeding, growing and binding of strands."""
