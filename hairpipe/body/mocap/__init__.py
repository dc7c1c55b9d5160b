"""Motion capture carried over to a body."""
