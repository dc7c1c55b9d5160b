"""Experiments on the model of hair: what is measured, and against what."""
