"""Graphs that measure the model, with the node types that only they use."""
