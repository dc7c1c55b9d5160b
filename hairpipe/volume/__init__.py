"""Hair as one material: mass and momentum of strands on dense grids, and what acts on it there."""
