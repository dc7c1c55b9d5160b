"""Graph files that people run."""
