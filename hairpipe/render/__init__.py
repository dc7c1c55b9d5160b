"""Pictures of hair and body: a software rasteriser, and Blender's Cycles."""
