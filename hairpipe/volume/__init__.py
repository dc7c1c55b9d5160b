"""Hair as a continuum: mass and momentum of strands on dense grids, smoothing, pressure, targets."""
