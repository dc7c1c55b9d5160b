"""Hair against hair."""
