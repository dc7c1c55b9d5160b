"""Skeletons, motion capture and skinning."""
