"""Parts of bodies of files: joints without scale, ends of bones; influences, shapes and maps of several meshes.

Distance of the cage of a subdivision surface, which is what we read, from its limit surface.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.values import BlendShapes


class Key(NamedTuple):
    """One key of a blend shape of a mesh.

    name      of the weight
    place     value of the weight at which the key is reached
    vertices  of the mesh, (r,)
    offsets   displacement of the bound mesh [m], (r, 3) float64
    """

    name: str
    place: float
    vertices: np.ndarray
    offsets: np.ndarray


def join_shapes(
    pieces: Sequence[Sequence[Key]], counts: Sequence[int], rest: Mapping[str, float]
) -> BlendShapes | None:
    """Join the keys of several meshes: keys of one name follow one weight; None without keys. Pure.

    counts  vertices of each mesh
    rest    weights that are not 0 at rest

    Raises BadInput where a mesh has a key at a weight of 0, or two of a name at one weight.
    """
    firsts = np.cumsum([0, *counts])
    keys = [key._replace(vertices=key.vertices + first) for p, first in zip(pieces, firsts, strict=False) for key in p]
    if not keys:
        return None
    meshes = np.repeat(np.arange(len(pieces), dtype=np.int32), [len(piece) for piece in pieces])
    seen = set[tuple[int, str, float]]()
    for mesh, key in zip(meshes.tolist(), keys, strict=True):
        if not key.place or (mesh, key.name, key.place) in seen:
            what = f"{'a' if not key.place else 'a second'} key at the weight {key.place or 0.0:g}"
            where = f"blend shape {key.name} of mesh {mesh}"
            raise BadInput(what, where=where, right="one key at each weight, none at 0")
        seen.add((mesh, key.name, key.place))
    names = tuple(dict.fromkeys(key.name for key in keys))
    return BlendShapes(
        names,
        np.array([rest.get(name, 0.0) for name in names]),
        np.array([names.index(key.name) for key in keys], np.int32),
        meshes,
        np.array([key.place for key in keys], float),
        np.cumsum([0] + [len(key.vertices) for key in keys]),
        np.concatenate([key.vertices for key in keys]).astype(np.int32),
        np.concatenate([key.offsets for key in keys]),
    )


def unique_names(names: Sequence[str], owners: Sequence[object]) -> list[str]:
    """Return names, those that several owners have with the owner: smile#face. Pure."""
    owned = dict[str, set[object]]()
    for name, owner in zip(names, owners, strict=True):
        owned.setdefault(name, set()).add(owner)
    return [n if len(owned[n]) == 1 else f"{n}#{owner}" for n, owner in zip(names, owners, strict=True)]


def rigid(world: np.ndarray) -> np.ndarray:
    """Return the nearest rotations, and the origins, of affine matrices (J, 4, 4); our joints have no scale. Pure."""
    left, _, right = np.linalg.svd(world[:, :3, :3])
    left[:, :, 2] *= np.linalg.det(left @ right)[:, None]
    result = world.copy()
    result[:, :3, :3] = left @ right
    return result


def find_tips(parents: np.ndarray, origins: np.ndarray) -> np.ndarray:
    """Return the end of every bone, (J, 3): the mean of its children; a leaf continues the bone of its parent."""
    tips = origins.copy()
    for joint, parent in enumerate(parents):
        children = np.flatnonzero(parents == joint)
        if len(children):
            tips[joint] = origins[children].mean(axis=0)
        elif parent >= 0:
            tips[joint] = 2 * origins[joint] - origins[parent]
    return tips


def stack_influences(rows: Sequence[np.ndarray]) -> np.ndarray:
    """Stack joints or weights (n, k) of several meshes, with several widths k, padded with zeros. Pure."""
    width = max(array.shape[1] for array in rows)
    return np.concatenate([np.pad(array, ((0, 0), (0, width - array.shape[1]))) for array in rows])


def merge_maps(maps: Sequence[Mapping[str, np.ndarray]], counts: Sequence[int]) -> dict[str, np.ndarray]:
    """Return every map over the vertices of all meshes, 0 on meshes without it. Pure.

    counts  vertices of each mesh
    """
    names = sorted({name for given in maps for name in given})
    bare = [np.zeros(count) for count in counts]
    return {name: np.concatenate([m.get(name, b) for m, b in zip(maps, bare, strict=True)]) for name in names}


VISIBLE = 1 / 200
"""Largest distance of the limit surface that is not reported, as a share of the size of the mesh."""


def warn_of_cage(where: str, points: np.ndarray, sizes: np.ndarray, corners: np.ndarray, scheme: str) -> None:
    """Warn where vertices of a cage lie visibly off the limit surface; see `limit_points`.

    Loop's is a scheme of triangles.
    """
    if scheme == "loop" and (sizes != 3).any():
        return
    away = np.linalg.norm(limit_points(points, sizes, corners, scheme) - points, axis=1)
    size = np.ptp(points, axis=0).max(initial=0.0)
    if away.max(initial=0.0) > VISIBLE * size:
        what = f"is a subdivision surface ({scheme}), of which the cage is read"
        off = f"its vertices are up to {100.0 * away.max() / size:.2g} % of the size of the mesh off the surface"
        warnings.warn(f"{where} {what}: {off} (subdivide the mesh before the export, or scheme none)", stacklevel=2)


def limit_points(points: np.ndarray, sizes: np.ndarray, corners: np.ndarray, scheme: str) -> np.ndarray:
    """Return the places of the vertices of a cage on its limit surface, (n, 3) float64; pure.

    Interior vertices by the masks of Catmull-Clark, with one refinement for polygons of any size (Halstead, Kass,
    DeRose 1993), or of Loop; those at a boundary by its cubic B-spline. Creases are not considered.

    points   (n, 3); sizes  corners of each polygon, (p,); corners  vertices of polygons, one after another, (c,)
    scheme   catmullClark or loop
    """
    owners = np.repeat(np.arange(len(sizes)), sizes)
    ends = np.cumsum(sizes) - 1
    ahead = np.arange(1, len(corners) + 1)
    ahead[ends] = ends + 1 - sizes
    pairs = np.stack([corners, corners[ahead]], axis=1)
    edges, edge_of, uses = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge_of = edge_of.reshape(-1)
    centres = _sums(owners, points[corners], len(sizes)) / sizes[:, None]
    valence = np.bincount(edges.ravel(), minlength=len(points))[:, None]
    neighbours = _sums(edges.ravel(), points[edges[:, ::-1].ravel()], len(points))
    n = np.maximum(valence, 1)
    if scheme == "loop":
        beta = (5 / 8 - (3 / 8 + np.cos(2 * np.pi / n) / 4) ** 2) / n
        weight = 1.0 / (n + 3.0 / (8.0 * np.maximum(beta, 1e-12)))
        limit = (1.0 - n * weight) * points + weight * neighbours
    else:
        around = _sums(corners, centres[owners], len(points))
        first = ((n - 3) * points + (points * n + neighbours) / n + around / n) / n
        faces = _sums(edge_of, centres[owners], len(edges))
        middles = (points[edges].sum(axis=1) + faces) / 4.0
        around_limit = 4.0 * _sums(edges.ravel(), np.repeat(middles, 2, axis=0), len(points)) + around
        limit = (n**2 * first + around_limit) / (n * (n + 5))
    rim = np.flatnonzero(uses == 1)
    at_rim = np.bincount(edges[rim].ravel(), minlength=len(points))
    curve = (_sums(edges[rim].ravel(), points[edges[rim][:, ::-1].ravel()], len(points)) + 4.0 * points) / 6.0
    limit = np.where((at_rim == 2)[:, None], curve, limit)
    return np.where(((at_rim != 0) & (at_rim != 2))[:, None] | (valence == 0), points, limit)


def _sums(rows: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Return the sums of values (m, 3) by row, (count, 3); pure."""
    return np.stack([np.bincount(rows, column, count) for column in values.T], axis=1)
