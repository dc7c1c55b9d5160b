"""Accuracy of the spring network against the elastic rod that it models; one measured quantity a file."""
