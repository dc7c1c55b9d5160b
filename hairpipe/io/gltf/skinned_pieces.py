"""Meshes of a glTF file, with skins and morph targets, as samples of an animated mesh."""

import warnings
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from hairpipe.apart import recall
from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.io.gltf.animation import Animation
from hairpipe.io.gltf.document import Document
from hairpipe.io.mesh_cache.moving import Instant, Points, Shape, join_shapes, read_at
from hairpipe.io.polygons import warn_of_unused

KNOWN = ("POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "COLOR_0")
MOST_FRAMES = 1_000_000
"""Largest number of frames of an animation."""
TRIANGLES = 4
"""Mode of primitives: others are strips, fans, lines and points."""


@dataclass(frozen=True)
class Piece:
    """A mesh of a node, with welded vertices: formats for graphics cards have several where normals differ.

    points   at rest, in the space of the mesh [m], (n, 3) float64
    targets  displacements of the morph targets [m], (t, n, 3) float64
    skin     index of the skin; None without one, or without joints of vertices
    joints   nodes that move a vertex, (n, k) int64; weights  (n, k) float64, rows of sum 1
    maps     painted vertex values by name, (n,) float64
    """

    node: int
    points: np.ndarray
    targets: np.ndarray
    triangles: np.ndarray
    uv: np.ndarray | None
    skin: int | None
    joints: np.ndarray
    weights: np.ndarray
    maps: dict[str, np.ndarray]


class SkinnedPieces:
    """Samples of the meshes of a file, one a frame of the shot, see `hairpipe.io.mesh_cache.moving.Source`.

    Between keys rotations turn along arcs, which a cubic between sparse keys would not follow.
    """

    def __init__(self, path: Path, group: str | None, clip: str | None, fps: float, moves: bool = True) -> None:
        self.path, self.rate = path, fps
        self.document = Document(path)
        self.files = self.document.files()
        self.animation = Animation(self.document, clip, moves)
        self.pieces = [piece for node in self.animation.order for piece in self._pieces(node, group)]
        if not self.pieces:
            right = "a node with a mesh of triangles"
            raise BadInput(f"no mesh{'' if group is None else f' named {group}'}", where=path, right=right)
        self.skins = {p.skin: self._bind(p.skin) for p in self.pieces if p.skin is not None}
        first, last = self.animation.span or (0.0, 0.0)
        if not 0.0 <= (last - first) * fps <= MOST_FRAMES:
            right = f"at most {MOST_FRAMES:,} frames"
            raise BadInput(f"the animation takes {last - first:g} s", where=path, right=right)
        whole = np.arange(np.ceil(first * fps), np.floor(last * fps) + 1.0)
        codes = np.sort([first * fps, *whole, last * fps])
        self.codes = codes[np.insert(np.diff(codes) > 1e-6, 0, True)]
        self.own = [False] * len(self.pieces)

    def shape(self, sample: int) -> Shape:
        """Read the triangles, and all points at a sample."""
        points = self.sample(sample)
        meshes = [Mesh(p, piece.triangles, uv=piece.uv) for (p, _), piece in zip(points, self.pieces, strict=True)]
        return join_shapes([Shape(mesh, np.arange(len(mesh.triangles))) for mesh in meshes])

    def sample(self, sample: int) -> list[Points]:
        """Return the points of the meshes at a sample [m]."""
        return [(points, None) for points in self.at(float(self.codes[sample] / self.rate))]

    def at(self, time: float | None) -> list[np.ndarray]:
        """Return the points of the meshes at a time [s], or at rest for None [m], (n, 3) each."""
        world = self.animation.transforms(time)
        found = [self._deformed(piece, world, time) for piece in self.pieces]
        if not all(np.isfinite(points).all() for points in found):
            raise BadInput("points are not finite", where=self.path, right="smaller scales, weights and translations")
        return found

    def _deformed(self, piece: Piece, world: np.ndarray, time: float | None) -> np.ndarray:
        points = piece.points
        if len(piece.targets):
            weights = self.animation.weights(piece.node, len(piece.targets), time)
            points = points + np.einsum("t,tnx->nx", weights, piece.targets)
        if piece.skin is None:
            return points @ world[piece.node, :3, :3].T + world[piece.node, :3, 3]
        matrices = world[:, :3].copy()
        nodes, bind = self.skins[piece.skin]
        matrices[nodes] = (world[nodes] @ bind)[:, :3]
        moved = np.zeros_like(points)
        for k in range(piece.joints.shape[1]):
            m = matrices[piece.joints[:, k]]
            moved += piece.weights[:, k, None] * (np.einsum("nij,nj->ni", m[:, :, :3], points) + m[:, :, 3])
        return moved

    def _bind(self, skin: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the joints of a skin, nodes (j,), and their inverse bind matrices, (j, 4, 4)."""
        given = self.document.get("skins")[skin]
        nodes = np.array(given["joints"], np.int64)
        where = f"{self.path}, skin {skin}"
        if lost := set(given["joints"]).difference(self.animation.order):
            raise BadInput(f"the joint {min(lost)} is not in the scene", where=where, right="a node of the scene")
        if "inverseBindMatrices" not in given:
            return nodes, np.tile(np.eye(4), (len(nodes), 1, 1))
        found = self.document.numbers(given["inverseBindMatrices"], 16).reshape(-1, 4, 4)
        if len(found) < len(nodes):
            raise BadInput(f"there are {len(found)} inverse bind matrices", where=where, right=f"{len(nodes)}")
        return nodes, np.swapaxes(found, 1, 2)[: len(nodes)]

    def _pieces(self, node: int, group: str | None) -> list[Piece]:
        given = self.document.get("nodes")[node]
        if "mesh" not in given or not self._fits(node, group):
            return []
        mesh = self.document.get("meshes")[given["mesh"]]
        name = f"{self.path}, mesh {mesh.get('name', given['mesh'])}"
        parts = [p for p in mesh["primitives"] if p.get("mode", TRIANGLES) == TRIANGLES]
        if len(parts) < len(mesh["primitives"]):
            warnings.warn(f"{name} has lines, points, strips or fans, which are not read", stacklevel=2)
        counts = sorted({len(p.get("targets", ())) for p in parts})
        if len(counts) > 1:
            right = f"{counts[-1]} for each, or none"
            raise BadInput(f"a primitive has {counts[0]} morph targets", where=name, right=right)
        return [weld(self._primitive(part, node, name)) for part in parts]

    def _fits(self, node: int, group: str | None) -> bool:
        """Return whether the name of a node, or of one above it, is that of a group or fits its pattern."""
        while node >= 0:
            name = str(self.document.get("nodes")[node].get("name", ""))
            if group is None or name == group or fnmatchcase(name, group):
                return True
            node = self.animation.parents[node]
        return False

    def _primitive(self, part: dict[str, Any], node: int, where: str) -> Piece:
        given = part.get("attributes", {})
        if "POSITION" not in given:
            raise BadInput("a primitive has no positions", where=where, right="the attribute POSITION")
        points = self.document.numbers(given["POSITION"], 3).astype(float)
        n = len(points)
        if not n:
            raise BadInput("a primitive has no positions", where=where, right="3 or more")

        def numbers(index: int, columns: int) -> np.ndarray:
            """Return a value of each vertex."""
            found = self.document.numbers(index, columns)
            if len(found) != n:
                at = f"{self.path}, accessor {index}"
                raise BadInput(f"{len(found)} elements for {n} vertices", where=at, right="as many as positions")
            return found

        corners = self.document.numbers(part["indices"], 1).astype(np.int64) if "indices" in part else np.arange(n)
        if len(corners) % 3 or (len(corners) and not 0 <= corners.min() <= corners.max() < n):
            raise BadInput("indices are not those of triangles", where=where, right=f"triples of 0 to {n - 1}")
        targets = [numbers(t["POSITION"], 3) if "POSITION" in t else np.zeros((n, 3)) for t in part.get("targets", ())]
        sets = [k for k in range(16) if f"JOINTS_{k}" in given and f"WEIGHTS_{k}" in given]
        influences = [[numbers(given[f"{name}_{k}"], 4) for k in sets] for name in ("JOINTS", "WEIGHTS")]
        skin = self.document.get("nodes")[node].get("skin") if sets else None
        joints, weights = self._influences(*influences, skin, node, n, where)
        triangles = corners.reshape(-1, 3)
        uv = numbers(given["TEXCOORD_0"], 2)[triangles] * (1, -1) + (0, 1) if "TEXCOORD_0" in given else None
        scalars = self.document.get("accessors")
        painted = [k for k, index in given.items() if k.startswith("_") and scalars[index].get("type") == "SCALAR"]
        maps = {name[1:].lower(): numbers(given[name], 1).astype(float).clip(0.0, 1.0) for name in painted}
        known = [name for name in given if name.startswith(("JOINTS_", "WEIGHTS_"))]
        warn_of_unused(where, given.keys() - {*KNOWN, *painted, *known})
        stacked = np.array(targets, float).reshape(-1, n, 3)
        texture = None if uv is None else uv.astype(np.float32)
        return Piece(node, points, stacked, triangles, texture, skin, joints, weights, maps)

    def _influences(
        self, indices: list[np.ndarray], shares: list[np.ndarray], skin: int | None, node: int, n: int, where: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes that move vertices, (n, k), and their weights, (n, k), rows of sum 1.

        indices, shares  joints of the skin and weights, of each set of four
        """
        if skin is None:
            return np.full((n, 1), node), np.ones((n, 1))
        nodes = np.array(self.document.get("skins")[skin]["joints"], np.int64)
        joints = np.concatenate(indices, axis=1).astype(int)
        weights = np.concatenate(shares, axis=1).astype(float)
        if joints.min() < 0 or joints.max() >= len(nodes) or weights.min() < 0.0:
            right = f"joints 0 to {len(nodes) - 1}, weights of 0 or more"
            raise BadInput("a vertex has an invalid joint or weight", where=where, right=right)
        bare = weights.sum(axis=1) == 0.0
        weights[bare, 0] = 1.0
        return nodes[joints], weights / weights.sum(axis=1, keepdims=True)


def weld(piece: Piece) -> Piece:
    """Return a mesh whose equal vertices, in position, morph targets, skin and maps, are one; pure."""
    n = len(piece.points)
    columns = [piece.points, piece.targets.swapaxes(0, 1).reshape(n, -1), piece.joints, piece.weights]
    columns += [values[:, None] for values in piece.maps.values()]
    rows = np.ascontiguousarray(np.concatenate(columns, axis=1) + 0.0)
    _, first, place = np.unique(
        rows.view([("", rows.dtype)] * rows.shape[1])[:, 0], return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    kept = first[order]
    triangles = np.argsort(order)[place.reshape(-1)][piece.triangles]
    real = (triangles != triangles[:, (1, 2, 0)]).all(axis=1)
    return Piece(
        piece.node,
        piece.points[kept],
        piece.targets[:, kept],
        np.ascontiguousarray(triangles[real], np.int32),
        None if piece.uv is None else piece.uv[real],
        piece.skin,
        piece.joints[kept],
        piece.weights[kept],
        {name: values[kept] for name, values in piece.maps.items()},
    )


def read_moving(path: Path, group: str | None, clip: str | None, instant: Instant) -> Shape:
    """Read the meshes of a clip at an instant."""
    return read_at(recall(SkinnedPieces, path, group, clip, instant.fps), instant)
