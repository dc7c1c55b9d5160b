"""Graphs by the path of a file, or by the name of one that is shipped."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from hairpipe.errors import BadInput
from hairpipe.graph.node.messages import nearest

if TYPE_CHECKING:
    from hairpipe.graph.file.graph import Graph, Node


def shipped_graphs() -> dict[str, Path]:
    """List the graphs that are installed with hairpipe, by name."""
    import hairpipe.graphs  # pyright: ignore[reportMissingImports] - the folder graphs, once installed

    folder = Path(hairpipe.graphs.__file__).parent
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.toml"))}


def find_graph(given: str) -> Path:
    """Find the file of a graph: a file of this path, else the shipped graph of this name."""
    path, graphs = Path(given), shipped_graphs()
    if path.is_file():
        return path
    if given in graphs:
        return graphs[given]
    if path.exists() or path.suffix:
        return path  # the reader says what is wrong with it
    raise BadInput(f"no graph '{given}'", right=f"a graph file, or one that is shipped; {nearest(given, [*graphs])}")


def open_graph(given: str, overrides: Mapping[str, str], to: Iterable[str] = ()) -> "Graph":
    """Read a graph by path or name, and cut it behind the nodes named in `to`.

    A shipped graph publishes as if its file lay in a folder `graphs` of the current folder, for where it really lies
    is nobody's place to write.
    """
    from hairpipe.graph.file.load import load_graph

    path = find_graph(given)
    graph = load_graph(path, overrides)
    if path != Path(given):
        folder = Path.cwd() / Path("graphs", given).parent
        nodes = {node.name: publish_below(folder, node, path.parent) for node in graph.nodes.values()}
        graph = replace(graph, project=Path.cwd(), nodes=nodes)
    return graph.upto(to) if to else graph


def publish_below(folder: Path, node: "Node", original: Path) -> "Node":
    """Let a node publish relative to another folder than that of its graph file."""
    if node.publish is None:
        return node
    path = os.path.normpath(folder / os.path.relpath(node.publish, original.resolve()))
    return replace(node, publish=Path(path).resolve())
