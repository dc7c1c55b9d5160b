"""Cost of the shot of a graph: frames of the paper, the first frame, compilation."""
