"""Level sets of a body in parts, each carried by its bones."""
