"""Find a graph by a path, the name of a shipped graph, the text of a graph, or its tables."""

import os
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hairpipe.engine.file.graph import HOLDS_GRAPHS, Graph, Node
from hairpipe.engine.file.load import make_graph, written_out
from hairpipe.engine.file.overrides import Tables, put
from hairpipe.engine.file.read import GraphText, read_graph_text
from hairpipe.engine.file.wedge import Wedge, read_wedges
from hairpipe.engine.node.messages import nearest
from hairpipe.errors import BadInput

Given = str | os.PathLike[str] | Mapping[str, Any]
UNNAMED = "<text>"  # name in messages of a graph without a file


@dataclass(frozen=True)
class Source:
    """A graph that was read, before its check.

    text     its tables, and their lines
    shipped  name of a graph that is installed with hairpipe; None for any other graph
    project  folder in which a shipped graph publishes, as if its file lay in `graphs` there
    may_be_empty  whether a graph without nodes is accepted
    """

    text: GraphText
    shipped: str | None = None
    project: Path | None = None
    may_be_empty: bool = False

    @property
    def given(self) -> str:
        """Name or path by which `read_source` finds it; BadInput for a graph that has no file."""
        if self.text.path.name == UNNAMED:
            raise BadInput("has no file", where=UNNAMED, right="a graph file, or the name of a shipped graph")
        return self.shipped or os.fspath(self.text.path)

    @property
    def tables(self) -> Tables:
        """A copy of the tables, with `like` expanded; BadInput for an invalid `like`."""
        return deepcopy(written_out(self.text).tables)

    @property
    def wedges(self) -> dict[str, Wedge]:
        """The wedges, by name; BadInput where one is faulty."""
        return read_wedges(self.text)

    def edited(self, tables: Mapping[str, Any]) -> "Source":
        """Return the same graph with other tables; pure."""
        return replace(self, text=self.text.edited(plain(tables)))

    def changed(self, settings: Mapping[str, Any]) -> "Source":
        """Return the same graph with settings changed, given by `node.setting` or `node.group.setting`; pure."""
        tables = deepcopy(self.text.tables)
        for target, value in settings.items():
            put(tables, target, plain(value))
        return self.edited(tables)

    def graph(self) -> Graph:
        """Check the graph; BadInput for the first fault, with file and line."""
        graph = make_graph(self.text, empty=self.may_be_empty)
        if self.shipped is None or self.project is None:
            return graph
        folder = Path(self.project, HOLDS_GRAPHS, self.shipped).parent
        nodes = {node.name: publish_below(folder, node, graph.path.parent) for node in graph.nodes.values()}
        return replace(graph, project=self.project, nodes=nodes)


def read_source(given: Given, folder: str | os.PathLike[str] | None = None) -> Source:
    """Read a graph; BadInput for a missing graph, or a text that is not TOML.

    given   path of a file; as a str without a newline, path of a file or name of a shipped graph; as a str with a
            newline, the text of a graph; as a mapping, its tables
    folder  folder of a text or of tables, the current one by default: files, `nodes` and published files are relative
            to it
    """
    if isinstance(given, Mapping):
        return Source(GraphText(Path(folder or Path.cwd(), UNNAMED), "").edited(plain(given)))
    if isinstance(given, str) and "\n" in given:
        return Source(GraphText(Path(folder or Path.cwd(), UNNAMED), given))
    if folder is not None:
        what = f"folder = {os.fspath(folder)!r} does not apply to a graph that has a file"
        raise BadInput(what, where=given, right="folder with a text or with tables only")
    path = find_graph(given)
    if path == Path(given):
        return Source(read_graph_text(path))
    return Source(read_graph_text(path), os.fspath(given), Path.cwd())


def shipped_graphs() -> dict[str, Path]:
    """List the graphs that are installed with hairpipe, by name."""
    import hairpipe.graphs  # pyright: ignore[reportMissingImports] - the folder graphs, once installed

    folder = Path(hairpipe.graphs.__file__).parent
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(folder.rglob("*.toml"))}


def find_graph(given: str | os.PathLike[str]) -> Path:
    """Find the file of a graph: a file of this path, else, for a str, the shipped graph of this name."""
    path = Path(given)
    graphs = shipped_graphs() if isinstance(given, str) else {}
    if path.is_file():
        return path
    if given in graphs:
        return graphs[os.fspath(given)]
    if path.exists() or path.suffix or not graphs:
        return path  # the reader reports its faults
    raise BadInput(
        f"no graph '{given}'", right=f"a graph file, or one that is shipped; {nearest(str(given), [*graphs])}"
    )


def publish_below(folder: Path, node: Node, original: Path) -> Node:
    """Return a node that publishes relative to another folder than that of its graph file; pure."""
    if node.publish is None:
        return node
    path = os.path.normpath(folder / os.path.relpath(node.publish, original.resolve()))
    return replace(node, publish=Path(path).resolve())


def plain(value: Any) -> Any:
    """Convert a value to TOML: lists for tuples and arrays, numbers for scalars of numpy, texts for paths."""
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return value.tolist()
    return os.fspath(value) if isinstance(value, os.PathLike) else value
