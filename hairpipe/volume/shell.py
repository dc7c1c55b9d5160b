"""The hair shell: the surface at which hair, seen as a volume, is as dense as a share of what hair has around it.

After Petrovic, Henne, Anderson 2005, Sec. 4.1. They solve |grad S| = 1 from the density; we take the mesh between, and
bake that as we bake bodies: the shell is shown, exported and a collider as any of them is.
"""

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from hairpipe.data import Density, Mesh
from hairpipe.errors import BadInput
from hairpipe.spatial.isosurface import extract_surface

REACH = 4
"""Standard deviations after which the blur ends."""


def shell_of(density: Density, blur: float, level: float) -> Mesh:
    """Return the closed surface of hair, outward, which moves as hair there does on average; pure.

    blur   standard deviation of a Gaussian by which the density is blurred before, in cells
    level  where it lies, over the median of the blurred density, each place counting by the hair in it

    Petrovic, Henne, Anderson 2005, Sec. 4.1. Raises BadInput where there is no hair, or nowhere so much.
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
    """The value below which the values of half the weight are."""
    order = np.argsort(values, axis=None, kind="stable")
    heaped = np.cumsum(weights.ravel()[order])
    return float(values.ravel()[order[np.searchsorted(heaped, 0.5 * heaped[-1])]])
