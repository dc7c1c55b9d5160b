"""What corrects positions and velocities between solves; a filter is never a force."""
