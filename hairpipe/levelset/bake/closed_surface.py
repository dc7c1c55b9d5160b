"""The closed surface of a moving body, as the triangles that a level set is baked from."""

from typing import NamedTuple
from warnings import warn

import numpy as np

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.levelset.bake.holes import Hole, capped, describe, edge_uses, holes
from hairpipe.spatial.triangle_tree import wide_triangles

# Beyond this the unit is wrong; and rounding would show [m].
FARTHEST = 1e6


class Surface(NamedTuple):
    """Independent triangles, each with its own corners.

    corners     [m], (m, 3, 3) float64
    velocities  of the corners [m/s], (m, 3, 3) float64
    """

    corners: np.ndarray
    velocities: np.ndarray


def closed_surface(mesh: Mesh, open_edges: str) -> Surface:
    """Return the mesh as a surface without holes; pure.

    open_edges  "fill": every hole is capped, with a warning; "refuse": a hole is an error

    Overlapping parts and edges shared by more than two triangles are allowed: the sign of the distance follows from a
    flood from outside. Raises BadInput for an empty, flat or broken mesh, and for holes that are refused.
    """
    mesh = checked(mesh)
    found, crowded = openings(mesh)
    if found and open_edges == "refuse":
        right = 'a closed mesh, or the setting holes = "fill"'
        raise BadInput(f"the surface is open: {describe(found)}", where="body", right=right)
    if found:
        warn(f"body: capped {describe(found)}", stacklevel=2)
    if crowded:
        warn(f"body: {crowded} edges have more than two triangles; the outer surface is used", stacklevel=2)
    mesh = capped(mesh, found)
    surface = Surface(mesh.points[mesh.triangles], mesh.rates[mesh.triangles])
    wide_triangles(surface.corners)  # of a flat body there are none: it is refused before the samples are searched
    return surface


def checked(mesh: Mesh) -> Mesh:
    """Return the mesh with velocities, zero where it has none; raises BadInput where an array is unusable; pure."""
    points, triangles = mesh.points, mesh.triangles
    if len(points) == 0 or len(triangles) == 0:
        raise BadInput("the mesh is empty", where="body", right="at least one triangle")
    refuse_invalid(points, "point")
    wild = np.flatnonzero(((triangles < 0) | (triangles >= len(points))).any(axis=1))
    if len(wild):
        right = f"indices 0 to {len(points) - 1}"
        raise BadInput(f"triangle {wild[0]} names points {triangles[wild[0]].tolist()}", where="body", right=right)
    velocities = mesh.rates
    if velocities.shape != points.shape:
        right = f"one for each of the {len(points)} points"
        raise BadInput(f"the mesh has {len(velocities)} velocities", where="body", right=right)
    refuse_invalid(velocities, "velocity of point")
    return Mesh(points, triangles, velocities)


def refuse_invalid(rows: np.ndarray, name: str) -> None:
    """Raise BadInput naming the first row that holds a NaN, an infinity or an absurd number."""
    bad = np.flatnonzero(~(np.abs(rows) < FARTHEST).all(axis=1))
    if len(bad):
        given = ", ".join(f"{value:g}" for value in rows[bad[0]])
        raise BadInput(
            f"{name} {bad[0]} is ({given})",
            where="body",
            right=f"finite numbers, in metres and seconds, below {FARTHEST:g}",
        )


def openings(mesh: Mesh) -> tuple[list[Hole], int]:
    """Return the holes, and the number of edges shared by more than two triangles; pure.

    Coincident points count as one, so that a surface split along its texture seams is closed.
    """
    edges, uses = edge_uses(mesh.triangles)
    names = np.arange(len(mesh.points))
    if (uses % 2).any():
        _, first, same = np.unique(mesh.points, axis=0, return_index=True, return_inverse=True)
        names = first[same.reshape(-1)]
        edges, uses = edge_uses(names[mesh.triangles])
    return holes(edges[uses % 2 == 1], mesh.points), int((uses > 2).sum())
