"""Graphs that measure the model, with node types that they alone use."""
