"""Blender: import of shots, conversion of files, and the extension that simulates hair of a scene."""
