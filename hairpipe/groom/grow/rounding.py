"""Inputs of root placement: the mesh and the density, rounded so coarsely that floating-point errors change neither.

Root placement is chaotic. A root drawn in another triangle moves all others, so that an error of 1e-16 in one vertex
(another processor, another version of numpy) would give another groom. Rounded to coarse steps, the mesh is the same:
errors of 1e-12 m change a number of the bust in 4 of 10,000 cases, those of 1e-16 m in 4 of 100 million. Roots then
have the same triangles and barycentrics to the bit, since the placement uses only addition, multiplication, division
and square roots, which are exactly rounded everywhere, in a fixed order.
"""

import math
from collections.abc import Callable

import numpy as np

from hairpipe.data import Mesh
from hairpipe.spatial.triangles import Sites, area_vectors

Density = Callable[[Sites], np.ndarray]
"""Relative number of roots per area at sites, (k,) >= 0."""

SHIFT = 0.381966  # of the steps, by which no round number, binary or decimal, lies where two of them meet
POINT_STEPS, DENSITY_STEPS = 64, 256  # in the side of a triangle, and in the largest density


def rounded_mesh(mesh: Mesh, bearing: np.ndarray) -> Mesh:
    """Return the mesh with its points moved by up to a 70th of the side of a triangle with hair; pure.

    bearing  whether a triangle has hair, (m,) bool; the median of their areas determines the step
    """
    areas = np.linalg.norm(area_vectors(mesh)[bearing], axis=1)
    side = math.sqrt(2.0 * float(np.median(areas[areas > 0.0]))) if areas.any() else 1.0
    return Mesh(rounded(mesh.points, power_of_two(side) / POINT_STEPS), mesh.triangles)


def rounded_density(density: Density, largest: float) -> Density:
    """Return a density in whole steps, of which the largest has about DENSITY_STEPS: their sums are exact."""
    step = power_of_two(largest) / DENSITY_STEPS
    return lambda sites: rounded(density(sites), step) / step


def rounded(values: np.ndarray, step: float) -> np.ndarray:
    """Return values rounded to multiples of a step, which is a power of two; 0 stays 0."""
    return step * np.floor(values / step + SHIFT)


def power_of_two(size: float) -> float:
    """Return the power of two between size / 2 and size, up to a factor by which no round size is where two meet."""
    return math.ldexp(1.0, math.frexp(size * (1.0 + SHIFT))[1] - 1) if size > 0.0 else 1.0
