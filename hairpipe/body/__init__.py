"""Skeletons, motion capture and skinning; the surface of a body and what lies closest on it."""
