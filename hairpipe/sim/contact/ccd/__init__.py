"""Hair that would pass through hair in a step: continuous collision detection, and its answer."""
