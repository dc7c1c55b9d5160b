"""Holes of a mesh: the closed loops of its open edges, and the caps that close them."""

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from hairpipe.data import Mesh

NAMED = 4


class Hole(NamedTuple):
    """One loop of open edges.

    loop     its points, in order, (k,)
    length   its length [m]
    weights  share of every point in the middle of the loop: half of the two edges that meet there, (k,), sum 1
    centre   this middle [m], (3,) float64
    """

    loop: np.ndarray
    length: float
    weights: np.ndarray
    centre: np.ndarray


def edge_uses(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return every edge once, (e, 2) with its lower point first, and by how many triangles it is used, (e,); pure."""
    ends = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64), axis=1)
    ends = ends[ends[:, 0] != ends[:, 1]]
    size = triangles.max() + 1
    codes, uses = np.unique(ends[:, 0] * size + ends[:, 1], return_counts=True)
    return np.stack([codes // size, codes % size], axis=1), uses


def holes(edges: np.ndarray, points: np.ndarray) -> list[Hole]:
    """Return the loops that the open edges form, longest first; pure.

    edges  edges of an odd number of triangles, (e, 2)

    At every point of any mesh the number of such edges is even, so they always form closed loops.
    """
    return sorted((measured(loop, points) for loop in loops(edges)), key=lambda hole: -hole.length)


def loops(edges: np.ndarray) -> list[list[int]]:
    """Return the closed loops, none of which passes a point twice, that the edges fall into; pure."""
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


def measured(loop: list[int], points: np.ndarray) -> Hole:
    """Return the hole with its length and middle; pure."""
    here = points[loop]
    lengths = np.linalg.norm(np.roll(here, -1, axis=0) - here, axis=1)
    length = float(lengths.sum())
    shares = (lengths + np.roll(lengths, 1)) / (2 * length) if length > 0 else np.full(len(loop), 1 / len(loop))
    return Hole(np.array(loop), length, shares, shares @ here)


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
