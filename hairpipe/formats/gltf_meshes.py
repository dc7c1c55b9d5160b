"""Meshes of a glTF file, with skins and morph targets, as samples of an animated mesh.

Nodes of a glTF file over time: their transforms, and the weights of morph targets.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hairpipe.apart import recall
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, Shape, join_shapes, read_at
from hairpipe.formats.gltf import Document
from hairpipe.formats.polygons import warn_of_unused
from hairpipe.values import Mesh

WIDTHS = {"translation": 3, "rotation": 4, "scale": 3}
REST = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}


class Track(NamedTuple):
    """Keys of one property of a node.

    times   ascending [s], (k,)
    values  (k, c); of a cubic (k, 3, c): tangent before, value, tangent after
    kind    LINEAR, STEP or CUBICSPLINE
    """

    times: np.ndarray
    values: np.ndarray
    kind: str

    def at(self, time: float, turns: bool) -> np.ndarray:
        """Return the value at a time, (c,); rotations are quaternions (x, y, z, w) of length 1."""
        times = self.times
        held = self.values[:, 1] if self.kind == "CUBICSPLINE" else self.values
        k = int(np.searchsorted(times, time, side="right")) - 1
        if k < 0 or k >= len(times) - 1:
            return unit(held[0 if k < 0 else -1], turns)
        span = times[k + 1] - times[k]
        share = (time - times[k]) / span
        if self.kind == "STEP" or share == 0.0:
            return unit(held[k], turns)
        if self.kind == "CUBICSPLINE":
            square = share * share
            cube = square * share
            weights = 2 * cube - 3 * square + 1, span * (cube - 2 * square + share), 3 * square - 2 * cube
            _, first, leaving = self.values[k]
            arriving, second, _ = self.values[k + 1]
            sums = weights[0] * first + weights[1] * leaving + weights[2] * second + span * (cube - square) * arriving
            return unit(sums, turns)
        return slerp(held[k], held[k + 1], share) if turns else (1.0 - share) * held[k] + share * held[k + 1]


def unit(values: np.ndarray, turns: bool) -> np.ndarray:
    """Return values, those of a rotation with length 1."""
    return values / max(float(np.linalg.norm(values)), 1e-30) if turns else values


def slerp(first: np.ndarray, second: np.ndarray, share: float) -> np.ndarray:
    """Return the quaternion at a share of the shorter great arc between two."""
    first, second = unit(first, True), unit(second, True)
    cosine = float(first @ second)
    second, cosine = (second, cosine) if cosine >= 0.0 else (-second, -cosine)
    if cosine > 1.0 - 1e-9:
        return unit((1.0 - share) * first + share * second, True)
    angle = np.arccos(cosine)
    return (np.sin((1.0 - share) * angle) * first + np.sin(share * angle) * second) / np.sin(angle)


def find_take(clips: Sequence[Mapping[str, Any]]) -> list[int]:
    """Return the indices of the animations that play together with the first: those that move nothing that it moves.

    Programs write an animation for each object and for its shape keys; others move the same nodes in another way. Pure.
    """
    moved = set[tuple[Any, Any]]()
    found = list[int]()
    for number, clip in enumerate(clips):
        targets = [channel["target"] for channel in clip["channels"]]
        own = {(target.get("node"), target.get("path")) for target in targets}
        if moved.isdisjoint(own):
            found.append(number)
            moved |= own
    return found


class Animation:
    """The nodes of the scene of a file, and its animations of one take; none if nothing `moves`.

    tracks   by node and property
    parents  of all nodes, -1 at roots
    order    nodes of the scene, parents first
    """

    def __init__(self, document: Document, clip: str | None, moves: bool = True) -> None:
        self.document = document
        self.nodes = document.get("nodes")
        self.parents = np.full(len(self.nodes), -1)
        self.order = self._walk()
        self.tracks = self._read_tracks(clip) if moves else {}

    def _walk(self) -> list[int]:
        document = self.document
        scenes = document.get("scenes")
        children = {child for node in self.nodes for child in node.get("children", ())}
        roots = [node for node in range(len(self.nodes)) if node not in children]
        if scenes:
            roots = scenes[document.json.get("scene", 0)].get("nodes", [])
        order = dict[int, None]()
        pending = list(reversed(roots))
        while pending:
            node = pending.pop()
            if node in order:
                where = f"{document.path}, nodes[{node}]"
                raise BadInput("its nodes are not a tree", where=where, right="each node below one other, once")
            order[node] = None
            below = self.nodes[node].get("children", ())
            self.parents[list(below)] = node
            pending += reversed(below)
        return list(order)

    def _read_tracks(self, clip: str | None) -> dict[tuple[int, str], Track]:
        document = self.document
        clips = document.get("animations")
        names = [str(animation.get("name", index)) for index, animation in enumerate(clips)]
        chosen = [given for given, name in zip(clips, names, strict=True) if fnmatchcase(name, clip or name)]
        if clip is not None and not chosen:
            right = f"one of {', '.join(names[:12])}" if names else "no clip: the file has no animation"
            raise BadInput(f"there is no animation {clip!r}", where=document.path, right=right)
        if not clips:
            return {}
        if clip is None:
            numbers = find_take(clips)
            chosen = [clips[number] for number in numbers]
            if len(numbers) < len(clips):
                read = ", ".join(names[number] for number in numbers[:12])
                message = f"{document.path} has the animations {', '.join(names[:12])}: {read} is read"
                warnings.warn(f"{message}; `clip` selects another", stacklevel=2)
        found = {}
        for samplers, channel in ((c["samplers"], channel) for c in chosen for channel in c["channels"]):
            node, what = (channel["target"].get(name) for name in ("node", "path"))
            if node is None or what not in (*WIDTHS, "weights"):
                warnings.warn(f"{document.path}: a channel for {what} is not read", stacklevel=2)
                continue
            if channel["sampler"] >= len(samplers):
                where = f"{document.path}, animation of node {node}"
                raise BadInput(f"there is no sampler {channel['sampler']}", where=where, right=f"below {len(samplers)}")
            found[node, what] = self._read_track(samplers[channel["sampler"]], what)
        return found

    def _read_track(self, sampler: dict[str, Any], what: str) -> Track:
        times = self.document.numbers(sampler["input"], 1).astype(float)
        values = self.document.numbers(sampler["output"], WIDTHS.get(what, 1)).astype(float)
        kind = sampler.get("interpolation", "LINEAR")
        rows = (len(times), 3) if kind == "CUBICSPLINE" else (len(times),)
        where = f"{self.document.path}, accessor {sampler['output']}"
        is_ascending = len(times) > 0 and (np.diff(times) > 0.0).all()
        if not is_ascending or len(values) % np.prod(rows) or (what in WIDTHS and len(values) != np.prod(rows)):
            right = f"{'' if what in WIDTHS else 'a multiple of '}{np.prod(rows)} values, for ascending times"
            raise BadInput(f"{len(values)} values do not fit the times", where=where, right=right)
        return Track(times, values.reshape(*rows, -1), kind)

    @property
    def span(self) -> tuple[float, float] | None:
        """First and last time of all keys [s]; None without an animation."""
        ends = [(track.times[0], track.times[-1]) for track in self.tracks.values()]
        return (float(min(a for a, _ in ends)), float(max(b for _, b in ends))) if ends else None

    def transforms(self, time: float | None) -> np.ndarray:
        """Return the node-to-world matrices at a time [s], or at rest for None, column vectors, (N, 4, 4)."""
        world = np.tile(np.eye(4), (len(self.nodes), 1, 1))
        for node in self.order:
            parent = self.parents[node]
            local = self._local(node, time)
            world[node] = world[parent] @ local if parent >= 0 else local
        if not np.isfinite(world).all():
            where = f"{self.document.path}, nodes[{int(np.argmin(np.isfinite(world).all(axis=(1, 2))))}]"
            raise BadInput("the transform is not finite", where=where, right="smaller scales and translations")
        return world

    def _local(self, node: int, time: float | None) -> np.ndarray:
        given = self.nodes[node]
        if "matrix" in given:
            return np.array(given["matrix"], float).reshape(4, 4).T
        parts = {}
        for what, rest in REST.items():
            track = self.tracks.get((node, what))
            parts[what] = np.array(given.get(what, rest), float)
            if track is not None and time is not None:
                parts[what] = track.at(time, what == "rotation")
        x, y, z, w = unit(parts["rotation"], True)
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        )
        local = np.eye(4)
        local[:3, :3] = turn * parts["scale"]
        local[:3, 3] = parts["translation"]
        return local

    def weights(self, node: int, count: int, time: float | None) -> np.ndarray:
        """Return the weights of the morph targets of a node at a time, or at rest, (count,)."""
        track = self.tracks.get((node, "weights"))
        if track is not None and time is not None:
            values = track.at(time, False)
        else:
            given = self.nodes[node].get("weights")
            mesh = self.document.get("meshes")[self.nodes[node]["mesh"]]
            values = np.array(given if given is not None else mesh.get("weights", [0.0] * count), float)
        if len(values) != count:
            where = f"{self.document.path}, node {node}"
            raise BadInput(f"there are {len(values)} weights", where=where, right=f"{count}: one for each morph target")
        return values


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
    """Samples of the meshes of a file, one a frame of the shot, see `hairpipe.formats.animated_meshes.Source`.

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
