"""Baking of a mesh to a level set."""
