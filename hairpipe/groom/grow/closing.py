"""Closed body as an obstacle of growing hair, so that every point is inside or outside."""

import numpy as np

from hairpipe.data import Mesh
from hairpipe.levelset.bake.holes import Hole, capped, edge_uses, holes
from hairpipe.spatial.triangles import area_vectors

FLATTEST = 1e-3  # volume over area^(3/2) of a body: a ball has 0.094, a sheet closed by its own back 0


def closed(mesh: Mesh) -> Mesh:
    """Return a mesh without holes, their caps facing outward; pure.

    A sheet has no inside, and caps would only add a second sheet: it is returned unchanged.
    """
    edges, uses = edge_uses(mesh.triangles)
    found = holes(edges[uses % 2 == 1], mesh.points)
    if not found:
        return mesh
    whole = capped(mesh, [facing_outward(hole, mesh.triangles) for hole in found])
    areas = area_vectors(whole)
    middle = whole.points.mean(axis=0)
    volume = np.sum((whole.points[whole.triangles[:, 0]] - middle) * areas) / 3.0
    return whole if volume > FLATTEST * np.linalg.norm(areas, axis=1).sum() ** 1.5 else mesh


def facing_outward(hole: Hole, triangles: np.ndarray) -> Hole:
    """Return the hole with its loop in the sense of the triangles around it, which its cap then goes against; pure."""
    first, second = hole.loop[:2]
    along = (triangles == first) & (np.roll(triangles, -1, axis=1) == second)
    return hole if along.any() else hole._replace(loop=hole.loop[::-1], weights=hole.weights[::-1])
