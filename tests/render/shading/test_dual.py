"""Light that hair scatters: none is lost in white hair, and deep hair has the colour that was asked for."""

import numpy as np
import pytest

from hairpipe.render.lights import Light
from hairpipe.render.shading.dual import add_scattered, bessel, cone, streams
from hairpipe.render.shading.fibre import tabulate
from hairpipe.render.shading.kajiya_kay import Fibres
from hairpipe.render.shading.skin import IRRADIANCE

TURN = np.pi / 12 / IRRADIANCE
"""Between azimuths, and light of a lamp that fills 1."""
AZIMUTHS = (np.arange(24) + 0.5) * np.pi / 12
SINES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def furnace(colour: tuple[float, float, float], thick: float, slope: float = 0.0) -> np.ndarray:
    """What a slab of hairs along y sends to a far eye in light 1 from everywhere, (3,).

    The eye looks at it from above, at a slope along the hairs [rad], and sees one at the depth t with the density
    exp(-t); in the way of light from an azimuth about the hairs are more, by one over its cosine.
    """
    deep = np.arange(0.0, min(thick, 12.0), 0.05) + 0.025
    seen, along = np.zeros((len(deep), 3)), np.tile([0.0, 1.0, 0.0], (len(deep), 1))
    hair = Fibres(np.zeros_like(seen), along, np.zeros_like(seen), np.tile(colour, (len(deep), 1)), np.zeros(len(deep)))
    eye = 1e6 * np.array([0.0, np.sin(slope), np.cos(slope)])
    for sine, weight in zip(SINES, WEIGHTS, strict=True):
        for azimuth in AZIMUTHS:
            cosine, across = np.cos(azimuth), np.sqrt(1.0 - sine**2)
            light = Light(np.array([across * np.sin(azimuth), sine, across * cosine]), np.full(3, weight * TURN))
            before = (deep if cosine > 0 else thick - deep) / abs(cosine)
            met = np.stack([before, np.full(len(deep), thick / abs(cosine))], axis=1)
            add_scattered(seen, hair, eye, light, met, tabulate())
    return 0.05 * np.exp(-deep) @ seen / (1.0 - np.exp(-thick))
