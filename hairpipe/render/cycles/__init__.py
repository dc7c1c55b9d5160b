"""Pictures by Blender's path tracer, Cycles, which runs as a program of its own."""
