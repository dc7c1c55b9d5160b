"""Models of a strand: rod, network and chain; their rows, rest shapes and calibration."""
