"""Nodes of a glTF file over time: their transforms, and the weights of morph targets."""

import warnings
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.gltf import Document

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
    """Return the animations that play with the first, which move nothing that it moves: one for each object."""
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
