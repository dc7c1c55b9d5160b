"""Hair of a stage: reading of curves and their attributes, grooms for other programs."""
