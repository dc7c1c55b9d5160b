"""What every way of carrying hair through a step of time makes of a motion, against a converged run."""
