"""Even placement of hair roots on the scalp, as dense as painted.

Source: G. Turk, Re-tiling polygonal surfaces, SIGGRAPH 1992: points placed by area push each other apart.
We differ from the paper: the points follow a density, each with a reach of its own, r_i ~ (density_i)^(-1/2); and all
move at once, so that the result does not depend on an order or on the number of threads.
"""

from collections.abc import Callable

import numpy as np

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.groom.grow.geodesic import Terrain, survey, walk_all
from hairpipe.groom.grow.point_repulsion import repulsion, sort_into_cells
from hairpipe.spatial.triangles import Sites, area_vectors, site_points, unit_normals

Density = Callable[[Sites], np.ndarray]

SAMPLES = 16  # of the density in each triangle
HEXAGON = 2.0 / np.sqrt(3.0)  # spacing^2 x points per area of a hexagonal packing
WIDE, CLOSE = 1.28, 0.98  # reach in the first sweep and in the last, in units of the spacing of a hexagonal packing
LARGEST_REACH = 4.0  # where hair is sparse, in units of the mean reach
SWEEPS = 32
STEP, LONGEST = 0.35, 0.25  # of a push, and in units of the reach, that a point moves in a sweep


def seed_roots(mesh: Mesh, density: Density, count: int, random: np.random.Generator) -> Sites:
    """Place count points on a mesh, evenly and in proportion to a density.

    density  relative number of roots per area at sites, (k,) >= 0; no root is placed where it is zero
    Raise BadInput where the density is zero everywhere.
    """
    samples, weights = sample_triangles(mesh, density, random)
    mass = weights.sum(axis=1)
    if not mass.sum() > 0.0:
        raise BadInput("hair grows nowhere: the density is zero everywhere", right="paint some of the scalp")
    sites = choose(density, samples, weights, count, random)
    return spread(mesh, density, sites, mass)


def sample_triangles(mesh: Mesh, density: Density, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return barycentrics of random places in every triangle, (m, SAMPLES, 3), and density x area at each."""
    areas = np.linalg.norm(area_vectors(mesh), axis=1)
    places = random.dirichlet((1.0, 1.0, 1.0), size=(len(areas), SAMPLES))
    triangles = np.repeat(np.arange(len(areas), dtype=np.int32), SAMPLES)
    values = density(Sites(triangles, places.reshape(-1, 3))).reshape(-1, SAMPLES)
    return places, values * areas[:, None] / SAMPLES


def choose(
    density: Density, samples: np.ndarray, weights: np.ndarray, count: int, random: np.random.Generator
) -> Sites:
    """Return count sites, stratified by the cumulative weight of the triangles and at random places within them."""
    cumulative = np.cumsum(weights.sum(axis=1))
    levels = (np.arange(count) + random.random(count)) / count * cumulative[-1]
    triangles = np.searchsorted(cumulative, levels, side="right").astype(np.int32)
    places = random.dirichlet((1.0, 1.0, 1.0), size=(count, SAMPLES))
    values = density(Sites(np.repeat(triangles, SAMPLES), places.reshape(-1, 3))).reshape(-1, SAMPLES)
    barren = ~values.any(axis=1)
    places[barren], values[barren] = samples[triangles[barren]], weights[triangles[barren]]
    shares = np.cumsum(values, axis=1)
    picks = np.sum(shares <= random.random(count)[:, None] * shares[:, -1:], axis=1)
    return Sites(triangles, places[np.arange(count), picks])


def spread(mesh: Mesh, density: Density, sites: Sites, mass: np.ndarray) -> Sites:
    """Return sites after their points have pushed each other apart, staying where there is density.

    The reach shrinks from sweep to sweep: a wide one evens out how many there are, a close one how far they are from
    their neighbours, whose distances then vary by less than 5 %.

    mass  density x area of every triangle, (m,)
    """
    terrain, normals = survey(mesh, mass > 0.0), unit_normals(mesh)
    area = np.linalg.norm(area_vectors(mesh)[mass > 0.0], axis=1).sum()
    spacing = np.sqrt(HEXAGON * area / len(sites.triangles))
    mean_density = mass.sum() / area
    for mean_reach in np.linspace(WIDE, CLOSE, SWEEPS) * spacing:
        reach = mean_reach * np.minimum(np.sqrt(mean_density / density(sites)), LARGEST_REACH)
        points, facing = site_points(mesh, sites), normals[sites.triangles]
        forces = repulsion(points, facing, reach, sort_into_cells(points, mean_reach, reach.max()))
        sites = stroll(density, terrain, sites, shortened(STEP * forces, LONGEST * reach))
    return sites


def shortened(moves: np.ndarray, longest: np.ndarray) -> np.ndarray:
    """Return moves [m], (k, 3), no longer than longest [m], (k,)."""
    lengths = np.linalg.norm(moves, axis=1)
    return moves * (longest / np.maximum(lengths, longest))[:, None]


def stroll(density: Density, terrain: Terrain, sites: Sites, moves: np.ndarray) -> Sites:
    """Return sites moved along the surface by tangent vectors [m], (k, 3); none leaves the density."""
    triangles, barycentrics = sites.triangles.copy(), sites.barycentrics.copy()
    walk_all(*terrain, triangles, barycentrics, moves)
    left = ~(density(Sites(triangles, barycentrics)) > 0.0)
    triangles[left], barycentrics[left] = sites.triangles[left], sites.barycentrics[left]
    return Sites(triangles, barycentrics)
