"""Charts as PNG, by matplotlib: the same picture gives the same bytes."""
