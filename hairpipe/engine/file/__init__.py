"""Graph files: from text to a checked graph."""
