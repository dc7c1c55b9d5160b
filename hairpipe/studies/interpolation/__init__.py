"""Bodies between two frames: what the interpolations of their level sets make of them."""
