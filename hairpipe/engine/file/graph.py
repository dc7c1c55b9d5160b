"""A graph: nodes, edges and a range of frames, immutable and checked; and one graph of several variants.

`load.py` builds a graph. In that of variants equal nodes occur once.
"""

import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from hairpipe.engine.node.declare import Cuts, NodeType
from hairpipe.engine.node.messages import nearest
from hairpipe.engine.node.settings import field_at, fields_of, map_files
from hairpipe.engine.store.digest import canonical, digest_bytes
from hairpipe.errors import BadInput

FRAME_MARK = re.compile("#+")
HOLDS_GRAPHS = "graphs"


class Edge(NamedTuple):
    """The source of a socket: a node and one of its outputs."""

    node: str
    output: str


@dataclass(frozen=True, eq=False, repr=False)
class Node:
    """A node of a graph.

    edges       by socket, or by `socket.0`, `socket.1` ... of a socket with a list; without unconnected sockets
    settings    checked plain values; a file is the path as given, relative to the graph file
    publish     path of the published file, with `####` in place of the frame; None if it is not published
    checkpoint  interval of a scan: the full state of every n-th frame is kept
    """

    name: str
    type: NodeType
    edges: dict[str, Edge]
    settings: dict[str, Any]
    publish: Path | None
    checkpoint: int

    def __repr__(self) -> str:
        edges = ", ".join(f"{plug} from {'.'.join(filter(None, edge))}" for plug, edge in self.edges.items())
        return f"<Node {self.name}: {self.type.name}{edges and f', {edges}'}>"

    @property
    def per_frame(self) -> bool:
        return self.type.mode != "once"

    def publish_path(self, frame: int | None) -> Path | None:
        if self.publish is None or frame is None:
            return self.publish
        name = FRAME_MARK.sub(lambda mark: f"{frame:0{len(mark[0])}d}", self.publish.name)
        return self.publish.with_name(name)


@dataclass(frozen=True, eq=False, repr=False)
class Graph:
    """Nodes in dependency order: a node follows those that it depends on.

    project  folder below which files are published; resolved
    frames   first and last, both included
    fps      frames per second [1/s]
    taken    connected outputs; for a part of a graph, those of the whole graph
    preroll  number of frames before the first that only scans compute
    cuts     frames at which the shot is cut, ascending
    """

    path: Path
    project: Path
    frames: tuple[int, int]
    fps: float
    nodes: dict[str, Node]
    taken: frozenset[Edge]
    preroll: int = 0
    cuts: tuple[int, ...] = ()

    def __repr__(self) -> str:
        first, last = self.frames
        return f"<Graph {self.path}: {len(self.nodes)} nodes, frames {first}-{last} at {self.fps:g} fps>"

    @property
    def folder(self) -> Path:
        """Folder of the node types of this graph, which may not exist."""
        return self.path.parent / "nodes"

    def file(self, given: str) -> Path:
        return (self.path.parent / given).absolute()

    def role(self, path: Path) -> str | None:
        """Describe the role of a file, by its resolved path, in this graph; None for an unrelated file."""
        if path.is_relative_to(self.folder.resolve()):
            return "in the folder of its node types"
        return self.files.get(path)

    @cached_property
    def files(self) -> dict[Path, str]:
        """The graph file and the inputs of its nodes: the role of each, by its resolved path."""
        files = {self.path.resolve(): "the graph file"}
        for node in self.nodes.values():
            given: list[tuple[str, str]] = []
            map_files(fields_of(node.type), node.settings, lambda *file, found=given: found.append(file))
            read = (path for file in given for path in self.read(node, *file).values())
            files |= {path.resolve(): f"an input of '{node.name}'" for path in read}
        return files

    def read(self, node: Node, setting: str, file: str) -> dict[str, Path]:
        """Return the files that a node reads for the file of a setting by their names; one alone has none.

        BadInput if one of them is missing.
        """
        field = field_at(node.type, setting.split("."))
        path = self.file(file)
        return field.reads.files(path) if field and field.reads else {"": path}

    def settings(self, node: Node) -> dict[str, Any]:
        return map_files(fields_of(node.type), node.settings, lambda _, file: str(self.file(file)))

    @property
    def begin(self) -> int:
        return self.frames[0] - self.preroll

    def cuts_of(self, node: Node, frame: int | None, run: tuple[int, ...]) -> Cuts:
        """Return the cuts that a node sees at a frame, see `Cuts`.

        frame  None for a `once` node
        run    frames of the run, ascending
        """
        if node.type.mode == "each":
            return Cuts(self.cuts)
        first, last = (run[0] + 1, run[-1]) if frame is None else (frame, frame)
        return Cuts(tuple(cut for cut in self.cuts if first <= cut <= last))

    @property
    def all_frames(self) -> range:
        return range(self.frames[0], self.frames[1] + 1)

    @cached_property
    def name(self) -> str:
        """Stem of the file, and a digest that distinguishes graphs of the same stem."""
        return f"{self.path.stem}-{digest_bytes('graph', os.fsencode(self.path.resolve()))[:8]}"

    def node(self, name: str) -> Node:
        """Find a node; BadInput with the nearest name where there is none."""
        if name not in self.nodes:
            raise BadInput(f"no node '{name}'", where=self.path, right=nearest(name, list(self.nodes)))
        return self.nodes[name]

    def upto(self, names: Iterable[str]) -> "Graph":
        """Return the graph of named nodes and their dependencies; BadInput for an unknown name."""
        wanted: set[str] = set()
        queue = [self.node(name).name for name in names]
        while queue:
            name = queue.pop()
            if name not in wanted:
                wanted.add(name)
                queue.extend(edge.node for edge in self.nodes[name].edges.values())
        return replace(self, nodes={name: node for name, node in self.nodes.items() if name in wanted})

    def select(self, frames: Iterable[int] | None) -> tuple[int, ...]:
        """Check a selection of frames against the range and the pre-roll; all frames of the range for None."""
        first, last = self.frames
        numbers = tuple(sorted(set(self.all_frames if frames is None else frames)))
        outside = [f for f in numbers if not self.begin <= f <= last]
        if outside or not numbers:
            what = f"frame {outside[0]} is outside the graph" if outside else "no frames are selected"
            raise BadInput(what, where=self.path, right=f"frames {first}-{last}")
        return numbers

    def output(self, node: str, name: str | None) -> str:
        """Find an output of a node, its first for None; BadInput with the nearest name where there is none."""
        outputs = list(self.node(node).type.outputs)
        if name is not None and name not in outputs:
            raise BadInput(f"'{node}' has no output '{name}'", where=self.path, right=nearest(name, outputs))
        return outputs[0] if name is None else name

    def consumers(self) -> Iterator[tuple[Node, str, Edge]]:
        """Iterate over all edges as (consumer, socket, edge)."""
        for node in self.nodes.values():
            for plug, edge in node.edges.items():
                yield node, plug, edge


def project_of(path: Path) -> Path:
    """Return the project folder of a graph file, found by names alone.

    This is the parent of the folder `graphs` above the file; without one, or if this parent is the home folder or above
    it, the folder of the file.
    """
    folder = path.parent.resolve()
    home = Path(os.path.expanduser("~")).resolve()  # noqa: PTH111 - no error where there is none
    above = next((place.parent for place in (folder, *folder.parents) if place.name == HOLDS_GRAPHS), folder)
    return folder if home.is_relative_to(above) else above


BEGIN, END = "[", "]"
"""Delimiters of the label of a variant; names of nodes in a graph file do not contain them."""
UNVARIED = "unvaried"
"""Label of a node that variants leave as it is in the graph file."""


def merged(
    variants: Mapping[str, Graph], name_of: Callable[[list[str]], str]
) -> tuple[Graph, dict[str, dict[str, str]]]:
    """Merge graphs with the same nodes and different settings; keys of results do not change. Pure.

    Returns the graph, and the names of its nodes by variant. Nodes that are equal in all variants keep their names and
    their paths of publication; others are named `node[name]` and published in a subfolder `name`.

    name_of  returns the name of a group of variants
    """
    first = next(iter(variants.values()))
    names: dict[str, dict[str, str]] = {label: {} for label in variants}
    nodes: dict[str, Node] = {}
    for name in first.nodes:
        alike: dict[str, list[str]] = {}
        for label, graph in variants.items():
            node = graph.nodes[name]
            edges: dict[str, Any] = {p: [names[label][edge.node], edge.output] for p, edge in node.edges.items()}
            alike.setdefault(canonical({"edges": edges, "settings": node.settings}), []).append(label)
        for labels in alike.values():
            label = "" if len(alike) == 1 else name_of(labels)
            node = renamed(variants[labels[0]].nodes[name], names[labels[0]], label)
            nodes[node.name] = node
            for label in labels:
                names[label][name] = node.name
    taken = frozenset(Edge(own[edge.node], edge.output) for own in names.values() for edge in first.taken)
    return replace(first, nodes=nodes, taken=taken), names


def unvaried(graph: Graph, base: Graph, varied: Collection[str]) -> Graph:
    """Return a variant in which the unvaried sockets of its nodes are connected to results of the graph file. Pure.

    Nodes of the graph file whose results the variants change are added for them, as `node[unvaried]`.

    base    the graph file
    varied  names of the nodes with varied settings
    """
    changed = set(varied)
    for node in base.nodes.values():  # in dependency order
        if any(edge.node in changed for edge in node.edges.values()):
            changed.add(node.name)
    fixed = {
        (node.name, plug): edge.node
        for node in base.nodes.values()
        for plug, edge in node.edges.items()
        if node.type.socket(plug).name in node.type.unvaried and edge.node in changed
    }
    if not fixed:
        return graph
    names = {name: f"{name}{BEGIN}{UNVARIED}{END}" for name in base.upto(fixed.values()).nodes if name in changed}
    nodes: dict[str, Node] = {}
    for name, node in graph.nodes.items():
        edges = {plug: moved(edge, names) if (name, plug) in fixed else edge for plug, edge in node.edges.items()}
        nodes[name] = replace(node, edges=edges)
        if name in names:
            own = base.nodes[name]
            edges = {plug: moved(edge, names) for plug, edge in own.edges.items()}
            nodes[names[name]] = replace(own, name=names[name], edges=edges, publish=None)
    return replace(graph, nodes=nodes, taken=frozenset(e for node in nodes.values() for e in node.edges.values()))


def moved(edge: Edge, names: Mapping[str, str]) -> Edge:
    return Edge(names.get(edge.node, edge.node), edge.output)


def origin(name: str) -> str:
    """Return the name, in the graph file, of a node of a merged graph."""
    return name.partition(BEGIN)[0]


def base_name(name: str) -> str:
    """Return the name of a node without the label of a variant; one that the variants leave as it was keeps its mark.

    A variant and the graph that its wedge is merged into have equal names.
    """
    unvaried = f"{BEGIN}{UNVARIED}{END}"
    return origin(name) + (unvaried if unvaried in name else "")


def renamed(node: Node, names: Mapping[str, str], label: str) -> Node:
    edges = {plug: Edge(names[edge.node], edge.output) for plug, edge in node.edges.items()}
    if not label:
        return replace(node, edges=edges)
    publish = node.publish and node.publish.parent / label / node.publish.name
    return replace(node, name=f"{node.name}{BEGIN}{label}{END}", edges=edges, publish=publish)
