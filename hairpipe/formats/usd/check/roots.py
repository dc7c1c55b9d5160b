"""Roots of hair on a mesh: on authored faces, or at the nearest points."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hairpipe.formats.usd.check.nearest import nearest_on_triangles
from hairpipe.formats.usd.check.scene import Scene, Snapshot, Track

OFF = 0.01  # of a strand's length, that a bound root may be off the skin
LOOSE = 0.1  # of a strand's length, that the root of hair that says no face may be off it, or slide
FAR = 20.0  # times that, from which on a single root counts
MOST = 0.5  # of the strands, that stand on the mesh they stand on
PROBED = 64  # strands of which the nearest place is searched


@dataclass(frozen=True)
class Roots:
    """Roots of strands on a mesh.

    scene, hair, mesh  scene, hair of the roots, and mesh under them
    strands            strands with known roots, (s,) int64
    corners            points of the mesh around each root, (s, 3) int64
    weights            of these, (s, 3) float64
    authored           whether the file states the faces; else they are the nearest at the first time
    """

    scene: Scene
    hair: Track
    mesh: Track
    strands: np.ndarray
    corners: np.ndarray
    weights: np.ndarray
    authored: bool

    def on_skin(self, time: float | None) -> np.ndarray:
        """Return the places on the skin at a time, in the world, (s, 3) float64."""
        return np.einsum("sk,skx->sx", self.weights, self.scene.place(self.mesh, time)[self.corners])

    def misses(self, hair: Snapshot, time: float | None, *, tips: bool = False) -> np.ndarray:
        """Return the distances of the roots, or tips, of hair from the skin at a time, (s,) [scene units]."""
        ends = (hair.tips if tips else hair.roots)[self.strands]
        return np.linalg.norm(hair.placed[ends] - self.on_skin(time), axis=1)

    def far(self, hair: Snapshot, time: float | None) -> np.ndarray:
        """Return the roots so far off their authored skin that a single one is a fault, (s,) bool."""
        return self.authored & (self.misses(hair, time) > FAR * self.reach)

    @cached_property
    def reach(self) -> float:
        """Return the largest accepted distance of a root from the skin [scene units]."""
        hair = self.hair.first
        ends = hair.placed[1:] - hair.placed[:-1]
        length = np.median(hair.per_strand(np.add, np.delete(np.linalg.norm(ends, axis=1), hair.tips[:-1])))
        return float(length) * (OFF if self.authored else LOOSE)


def find_roots(scene: Scene, hair: Track) -> Roots | None:
    """Find the roots of hair: on authored faces, else on the moving mesh that is nearest at the first time."""
    path = hair.prim.GetPath()
    if path not in scene.roots:
        scene.roots[path] = _search(scene, hair)
    return scene.roots[path]


def _search(scene: Scene, hair: Track) -> Roots | None:
    authored = authored_roots(scene, hair)
    if authored or not (hair.first.sound and hair.moves) or hair.first.array("primvars:skinprim") is not None:
        return authored
    moving = [mesh for mesh in scene.meshes if scene.moves(mesh)]
    meshes = moving or (scene.meshes if len(scene.meshes) == 1 else [])
    return _best([roots for mesh in meshes if (roots := _nearest(scene, hair, mesh))])


def authored_roots(scene: Scene, hair: Track) -> Roots | None:
    """Find the mesh with the authored faces of the hair; the nearest of several."""
    return _best([roots for mesh in scene.skins if hair.first.sound and (roots := _authored_on(scene, hair, mesh))])


def _best(found: list[Roots]) -> Roots | None:
    first = [roots.hair.first for roots in found]
    misses = [np.median(roots.misses(hair, hair.code)) for roots, hair in zip(found, first, strict=True)]
    return found[int(np.argmin(misses))] if found else None


def _authored_on(scene: Scene, hair: Track, mesh: Track) -> Roots | None:
    """Return the roots on the authored triangles, if the mesh has them."""
    faces = hair.first.array("primvars:skinprim")
    uv = hair.first.array("primvars:skinprimuv", 2)
    skin = mesh.first
    count = len(hair.first.counts)
    if faces is None or uv is None or not len(faces) == len(uv) == count or not is_triangles(skin):
        return None
    known = (faces >= 0) & (faces < len(skin.counts))
    if known.mean() < MOST:
        return None
    corners = skin.corners.reshape(-1, 3)[faces[known].astype(np.int64)]
    inside = uv[known].astype(np.float64)  # so that weights sum to 1 also far from the origin
    weights = np.column_stack([1 - inside.sum(axis=1), inside])
    return Roots(scene, hair, mesh, np.flatnonzero(known), corners, weights, authored=True)


def is_triangles(mesh: Snapshot) -> bool:
    """Return whether all faces of a mesh are triangles of existing points."""
    whole = mesh.consistent and len(mesh.counts) and (mesh.counts == 3).all()
    inside = whole and mesh.corners.min() >= 0 and mesh.corners.max() < len(mesh.points)
    return bool(inside and np.isfinite(mesh.points).all())


def _nearest(scene: Scene, hair: Track, mesh: Track) -> Roots | None:
    """Return the nearest places on a mesh to some of the roots at the first time of the hair."""
    skin = mesh.first
    if not (skin.consistent and len(skin.counts) and skin.corners.max() < len(skin.points) and skin.corners.min() >= 0):
        return None
    strands = np.unique(np.linspace(0, len(hair.first.counts) - 1, PROBED).astype(np.int64))
    points = scene.place(mesh, hair.first.code)
    triangles = _fan(skin)
    if not (np.isfinite(points).all() and len(triangles)):
        return None
    face, weights = nearest_on_triangles(hair.first.placed[hair.first.roots[strands]], points[triangles])
    return Roots(scene, hair, mesh, strands, triangles[face], weights, authored=False)


def _fan(mesh: Snapshot) -> np.ndarray:
    """Return polygons as triangles about their first corner, (t, 3) int64."""
    firsts = np.cumsum(mesh.counts) - mesh.counts
    inner = np.maximum(mesh.counts - 2, 0)
    step = np.arange(inner.sum()) - np.repeat(np.cumsum(inner) - inner, inner)
    first = np.repeat(firsts, inner)
    return mesh.corners[np.stack([first, first + step + 1, first + step + 2], axis=1)].astype(np.int64)
