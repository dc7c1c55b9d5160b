"""Models of a strand: particles, constants, and forces. All models have the same interface."""
