"""The hair shell: the isosurface of the density of hair at a share of the median density.

After Petrovic, Henne, Anderson 2005, Sec. 4.1. They solve |grad S| = 1 from the density; we extract a mesh and bake it
as a body, so that the shell can be drawn, exported and used as a collider.
"""

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from hairpipe.data import Density, Mesh
from hairpipe.errors import BadInput
from hairpipe.spatial.isosurface import extract_surface

REACH = 4
"""Radius of the blur, in standard deviations."""


def shell_of(density: Density, blur: float, level: float) -> Mesh:
    """Return the closed surface of hair, outward, with the mean velocity of the hair there; pure.

    blur   standard deviation of a Gaussian by which the density is blurred before, in cells
    level  density of the surface, over the median of the blurred density, weighted by hair

    Petrovic, Henne, Anderson 2005, Sec. 4.1. Raises BadInput where there is no hair, or no place of that density.
    """
    if not density.length.any():
        raise BadInput("there is no hair", where="density")
    margin = int(np.ceil(REACH * blur)) + 1
    hair = np.pad(density.length.astype(float), margin)
    blurred = _blurred(hair, blur)
    surface = level * _median(blurred, hair)
    axes = tuple(density.cell * (low - margin + np.arange(n)) for low, n in zip(density.low, hair.shape, strict=True))
    points, triangles = extract_surface(surface - blurred, axes)
    if not len(triangles):
        raise BadInput(f"no density reaches {level:g} of the median", where="level", right="less")
    places = (points / density.cell - density.low + margin).T
    mass = map_coordinates(blurred, places, order=1)
    momenta = hair[..., None] * np.pad(density.velocity, [*[(margin, margin)] * 3, (0, 0)])
    flow = np.stack([map_coordinates(_blurred(momenta[..., c], blur), places, order=1) for c in range(3)], axis=1)
    return Mesh(points, triangles, flow / mass[:, None])


def _blurred(field: np.ndarray, blur: float) -> np.ndarray:
    return gaussian_filter(field, blur, mode="constant", truncate=REACH)


def _median(values: np.ndarray, weights: np.ndarray) -> float:
    """Return the weighted median."""
    order = np.argsort(values, axis=None, kind="stable")
    heaped = np.cumsum(weights.ravel()[order])
    return float(values.ravel()[order[np.searchsorted(heaped, 0.5 * heaped[-1])]])
