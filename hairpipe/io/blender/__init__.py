"""Import of a shot into Blender, which runs as a program of its own."""
