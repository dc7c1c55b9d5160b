"""The level set of a body with the distances of OpenVDB's conversion of a mesh, for comparison."""

import numpy as np

from hairpipe.data import LevelSet, Mesh
from hairpipe.levelset.bake.bricks import SIDE
from hairpipe.levelset.bake.closed_surface import closed_surface
from hairpipe.levelset.bake.whole import bake_solid
from hairpipe.levelset.grid_layout import BRICK, lattice_around
from hairpipe.openvdb_library import ask


def bake_by_openvdb(mesh: Mesh, voxel: float, half_width: float, open_edges: str) -> LevelSet:
    """Return the level set of `bake`, with distances and signs by OpenVDB's createLevelSetFromPolygons in the band.

    Velocities, bricks and distances beyond the band inside are those of `bake`, see there for arguments and errors.
    BadInput also where OpenVDB's module is missing or fails.
    """
    surface = closed_surface(mesh, open_edges)
    lattice = lattice_around(surface.corners, voxel, half_width)
    ours = bake_solid(surface, lattice, half_width)
    where = {"first": lattice.first, "samples": np.array(lattice.samples)}
    given = {"corners": surface.corners, "voxel": voxel, "half_width": half_width}
    theirs = ask("levelset", "bake_levelset", **given, **where)["distance"]
    places = np.argwhere(ours.bricks >= 0)
    distance = np.empty_like(ours.distance)
    for a, b, c in places.tolist():
        first, other, last = (slice(BRICK * i, BRICK * i + SIDE) for i in (a, b, c))
        distance[ours.bricks[a, b, c]] = theirs[first, other, last]
    width = np.float32(voxel * half_width)
    deep = np.minimum(ours.distance, -width)
    found = np.where(distance >= width, width, np.where(distance <= -width, deep, distance))
    return LevelSet(ours.bricks, found, ours.velocity, ours.inner, ours.origin, voxel, half_width)
