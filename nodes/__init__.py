"""Node types, one a file: users read and copy them."""
