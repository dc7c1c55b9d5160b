"""Prescribed motion of the ends of strands, by keys and by waves."""
