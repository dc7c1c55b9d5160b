"""Key hairs, which are simulated, and hair that is interpolated between them."""
