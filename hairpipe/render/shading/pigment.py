"""The colour of a lock by the pigment of its hairs."""

import numpy as np

ROUGHNESS = 0.3
"""Roughness of hair, along it and around it."""
EUMELANIN, PHEOMELANIN = np.array([0.506, 0.841, 1.653]), np.array([0.343, 0.733, 1.924])
"""What one unit of each absorbs of red, green and blue over the radius of a hair (d'Eon et al. 2011)."""
ALBEDO = (0.245, 5.574, -10.73, 2.532, -0.215, 5.969)
"""Coefficients of the polynomial in the roughness around a hair, the highest power first (Chiang et al. 2016)."""
LEAST = 1e-4
"""Light that the blackest hair lets through."""


def pigment_colour(melanin: float, redness: float) -> np.ndarray:
    """Return the colour of a lock of hairs by their pigment, linear red, green and blue, (3,) float64; pure.

    melanin  how much, from 0, white, to 1, black
    redness  share of it that is pheomelanin, which is red

    Melanin m is -ln(1 - m) units of pigment, as in Blender, so that m goes evenly from white to black. They absorb
    sigma, and a lock that does so has the colour exp(-f(b) sqrt(sigma)), with the polynomial f of the roughness b.
    """
    units = -np.log(max(1.0 - melanin, LEAST))
    absorbed = units * ((1.0 - redness) * EUMELANIN + redness * PHEOMELANIN)
    return np.exp(-np.polyval(ALBEDO, ROUGHNESS) * np.sqrt(absorbed))
