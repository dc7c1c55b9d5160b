"""Even placement of hair roots on the scalp with the painted density.

Source: G. Turk, Re-tiling polygonal surfaces, SIGGRAPH 1992: points placed by area repel each other. We differ from
the paper: the points follow a density, each with its own reach, r_i ~ (density_i)^(-1/2); and all move simultaneously,
so that the result does not depend on an order or on the number of threads. Mesh and density are rounded first, so that
it does not depend on floating-point errors either: see `rounding.py`.
"""

import math

import numpy as np

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.groom.grow.geodesic import Terrain, survey, walk_all
from hairpipe.groom.grow.point_repulsion import repulsion, sort_into_cells
from hairpipe.groom.grow.rounding import Density, rounded_density, rounded_mesh
from hairpipe.spatial.morton import morton_order
from hairpipe.spatial.triangles import Sites, area_vectors, site_points, unit_normals

SAMPLES = 16  # of the density in each triangle
HEXAGON = 2.0 / np.sqrt(3.0)  # spacing^2 x points per area of a hexagonal packing
WIDE, CLOSE = 1.28, 0.98  # reach in the first sweep and in the last, in units of the spacing of a hexagonal packing
LARGEST_REACH = 4.0  # where hair is sparse, in units of the mean reach
SWEEPS = 32
STEP, LONGEST = 0.35, 0.25  # of a push, and in units of the reach, that a point moves in a sweep


def seed_roots(mesh: Mesh, density: Density, count: int, random: np.random.Generator) -> Sites:
    """Place count points on a mesh, evenly and in proportion to a density; in Morton order.

    density  relative number of roots per area at sites, (k,) >= 0; no root is placed where it is zero
    Raises BadInput if the density is zero everywhere.
    """
    samples = draw_sites(np.arange(len(mesh.triangles)), random)
    density = rounded_density(density, float(density(samples).max(initial=0.0)))
    values = density(samples).reshape(-1, SAMPLES)
    mesh = rounded_mesh(mesh, values.any(axis=1))
    mass = np.linalg.norm(area_vectors(mesh), axis=1) * values.sum(axis=1) / SAMPLES
    if not mass.any():
        raise BadInput("no hair: the density is zero everywhere", right="paint some of the scalp")
    sites = spread(mesh, density, choose(density, samples, values, mass, count, random), mass)
    order = morton_order(site_points(mesh, sites))
    return Sites(*(array[order] for array in sites))


def draw_sites(triangles: np.ndarray, random: np.random.Generator) -> Sites:
    """Return SAMPLES random places in each of some triangles, (k,), one triangle after another, (SAMPLES k,)."""
    across, along = random.random((2, len(triangles) * SAMPLES))
    across = np.sqrt(across)
    barycentrics = np.stack([1.0 - across, across * (1.0 - along), across * along], axis=1)
    return Sites(np.repeat(triangles, SAMPLES).astype(np.int32), barycentrics)


def choose(
    density: Density, samples: Sites, values: np.ndarray, mass: np.ndarray, count: int, random: np.random.Generator
) -> Sites:
    """Return count sites, stratified by the cumulative mass of the triangles and at random places within them.

    values  density at the samples of every triangle, (m, SAMPLES), used as a fallback if new samples have density 0
    mass    density x area of every triangle, (m,)
    """
    cumulative = np.cumsum(mass)
    levels = (np.arange(count) + random.random(count)) / count * cumulative[-1]
    triangles = np.searchsorted(cumulative, levels, side="right")
    drawn = draw_sites(triangles, random)
    places, known = (sites.barycentrics.reshape(-1, SAMPLES, 3) for sites in (drawn, samples))
    found = density(drawn).reshape(-1, SAMPLES)
    barren = ~found.any(axis=1)
    places[barren], found[barren] = known[triangles[barren]], values[triangles[barren]]
    shares = np.cumsum(found, axis=1)
    picks = np.sum(shares <= random.random(count)[:, None] * shares[:, -1:], axis=1)
    return Sites(triangles.astype(np.int32), places[np.arange(count), picks])


def spread(mesh: Mesh, density: Density, sites: Sites, mass: np.ndarray) -> Sites:
    """Return sites after the repulsion of their points, restricted to positive density.

    The reach shrinks from sweep to sweep: a wide one equalises numbers, a short one the distances to neighbours, which
    then vary by less than 5 %.

    mass  density x area of every triangle, (m,)
    """
    terrain = survey(mesh, mass > 0.0)
    normals = unit_normals(mesh)
    area = math.fsum(np.linalg.norm(area_vectors(mesh)[mass > 0.0], axis=1))
    spacing = math.sqrt(HEXAGON * area / len(sites.triangles))
    mean_density = math.fsum(mass) / area
    for sweep in range(SWEEPS):
        mean_reach = spacing * (WIDE + (CLOSE - WIDE) * sweep / (SWEEPS - 1))
        reach = mean_reach * np.minimum(np.sqrt(mean_density / density(sites)), LARGEST_REACH)
        points = site_points(mesh, sites)
        facing = normals[sites.triangles]
        forces = repulsion(points, facing, reach, sort_into_cells(points, mean_reach, reach.max()))
        sites = stroll(density, terrain, sites, shortened(STEP * forces, LONGEST * reach))
    return sites


def shortened(moves: np.ndarray, longest: np.ndarray) -> np.ndarray:
    """Return moves [m], (k, 3), no longer than longest [m], (k,)."""
    lengths = np.linalg.norm(moves, axis=1)
    return moves * (longest / np.maximum(lengths, longest))[:, None]


def stroll(density: Density, terrain: Terrain, sites: Sites, moves: np.ndarray) -> Sites:
    """Return sites moved along the surface by tangent vectors [m], (k, 3); none leaves the density."""
    triangles = sites.triangles.copy()
    barycentrics = sites.barycentrics.copy()
    walk_all(*terrain, triangles, barycentrics, moves)
    left = ~(density(Sites(triangles, barycentrics)) > 0.0)
    triangles[left], barycentrics[left] = sites.triangles[left], sites.barycentrics[left]
    return Sites(triangles, barycentrics)
