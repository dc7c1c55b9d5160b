"""The closed surface of a moving body, as the triangles that a level set is baked from, and the caps of its holes."""

from collections import defaultdict
from typing import NamedTuple
from warnings import warn

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.triangle_tree import wide_triangles
from hairpipe.values import Mesh

NAMED = 4


class Hole(NamedTuple):
    """One loop of open edges."""

    loop: np.ndarray  # its points, in order, (k,)
    length: float  # [m]
    weights: np.ndarray  # of the points in the middle: half of the two edges that meet there, (k,), sum 1
    centre: np.ndarray  # this middle [m], (3,) float64


def edge_uses(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return every edge once, (e, 2) with its lower point first, and by how many triangles it is used, (e,); pure."""
    ends = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64), axis=1)
    ends = ends[ends[:, 0] != ends[:, 1]]
    size = triangles.max() + 1
    codes, uses = np.unique(ends[:, 0] * size + ends[:, 1], return_counts=True)
    return np.stack([codes // size, codes % size], axis=1), uses


def holes(edges: np.ndarray, points: np.ndarray) -> list[Hole]:
    """Return the loops that edges of an odd number of triangles, (e, 2), form, longest first; pure.

    At every point of any mesh the number of such edges is even, so they always form closed loops.
    """
    found = []
    for loop in loops(edges):
        here = points[loop]
        lengths = np.linalg.norm(np.roll(here, -1, axis=0) - here, axis=1)
        length = float(lengths.sum())
        shares = (lengths + np.roll(lengths, 1)) / (2 * length) if length > 0 else np.full(len(loop), 1 / len(loop))
        found.append(Hole(np.array(loop), length, shares, shares @ here))
    return sorted(found, key=lambda hole: -hole.length)


def loops(edges: np.ndarray) -> list[list[int]]:
    """Return the closed loops, none of which passes a point twice, that the edges fall into."""
    neighbours: dict[int, list[int]] = defaultdict(list)
    for a, b in edges.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    found = []
    for start in sorted(neighbours):
        path = [start]
        place = {start: 0}
        while neighbours[path[-1]]:
            here = path[-1]
            there = neighbours[here].pop()
            neighbours[there].remove(here)
            if there in place:
                found.append(path[place[there] :])
                for point in path[place[there] + 1 :]:
                    del place[point]
                del path[place[there] + 1 :]
            else:
                place[there] = len(path)
                path.append(there)
    return found


def capped(mesh: Mesh, found: list[Hole]) -> Mesh:
    """Return the mesh with every hole closed by a fan of triangles around its middle; pure.

    The middle moves as the edge does. A fan over a bent or concave loop may overlap itself; it is still closed, as the
    sign of the distance requires.
    """
    points, triangles, velocities = [mesh.points], [mesh.triangles], [mesh.rates]
    for number, hole in enumerate(found):
        hub = np.full(len(hole.loop), len(mesh.points) + number)
        points.append(hole.centre[None])
        velocities.append((hole.weights @ mesh.rates[hole.loop])[None])
        triangles.append(np.stack([np.roll(hole.loop, -1), hole.loop, hub], axis=1))
    return Mesh(np.concatenate(points), np.concatenate(triangles).astype(np.int32), np.concatenate(velocities))


def describe(found: list[Hole]) -> str:
    """Return the number of holes, and the size and place of the longest, for a message."""
    places = [
        f"{len(hole.loop)} edges, {hole.length:.3g} m around, at ({', '.join(f'{x:.3f}' for x in hole.centre)})"
        for hole in found[:NAMED]
    ]
    more = f"; and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return f"{len(found)} hole{'s' if len(found) > 1 else ''}: {'; '.join(places)}{more}"


# Beyond this the unit is wrong; and rounding would show [m].
FARTHEST = 1e6


class Surface(NamedTuple):
    """Independent triangles, each with its own corners."""

    corners: np.ndarray  # [m], (m, 3, 3) float64
    velocities: np.ndarray  # of the corners [m/s], (m, 3, 3) float64


def closed_surface(mesh: Mesh, open_edges: str) -> Surface:
    """Return the mesh as a surface whose holes are capped, with a warning, or are errors, open_edges = "refuse"; pure.

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
