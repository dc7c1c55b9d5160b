"""Hair grown from a scalp."""
