"""Node types: what the signature of a typed function declares."""
