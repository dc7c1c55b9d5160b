"""Hair against bodies."""
