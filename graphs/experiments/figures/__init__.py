"""Measured figures as data: recorded by commands, written into pages, compared with the current code."""
