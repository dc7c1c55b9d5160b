"""What the camera sees: lines, triangles and surfaces at the pixels."""
