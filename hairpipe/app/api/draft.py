"""A graph that is being edited: its text, the shot of its complete nodes, and what the other nodes lack."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hairpipe.app.api.cache import open_store
from hairpipe.app.api.shot import Shot
from hairpipe.app.api.source import Source, read_source
from hairpipe.engine.edit import locked, save_text, with_tables
from hairpipe.engine.file.bounds import Bounds, entered
from hairpipe.engine.file.graph import Edge
from hairpipe.engine.file.load import Incomplete, make_graph, muted_nodes, read_edges, written_out
from hairpipe.engine.file.overrides import LAYOUT, WEDGE, nodes_of
from hairpipe.engine.file.read import MOST_BYTES, GraphText, read_graph_text
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.file.wedge import read_wedges
from hairpipe.engine.node.declare import NodeType
from hairpipe.engine.node.settings import Field, field_at
from hairpipe.errors import BadInput

SCHEMA = "schema = 1\n"
EMPTY = f"{SCHEMA}frames = [1, 24]\nfps = 24\n"
"""Text of a graph to begin with."""


class Draft:
    """A graph file that is being edited; it does not change.

    text    of the file
    tables  of all nodes, with `like` expanded
    faults  what incomplete nodes lack, by name; these are not in the shot
    muted   names of nodes that are passed by, which are not in the shot either
    layout  positions of nodes on the page
    shot    of the complete nodes, which may be none
    """

    def __init__(self, source: Source, cache: Path) -> None:
        self._source = source
        self.text = source.text.text
        read_wedges(source.text)
        expanded = written_out(source.text)
        self.tables: dict[str, Any] = nodes_of(expanded.tables)
        self.layout: Mapping[str, Any] = expanded.tables.get(LAYOUT, {})
        self.muted = muted_nodes(source.text, self.tables)
        self.faults: dict[str, str] = {}
        checked = replace(source, may_be_empty=True)
        try:
            self.shot = Shot(checked, open_store(cache))
        except Incomplete:
            self.faults = incomplete(expanded)
            left = {n: table for n, table in expanded.tables.items() if n not in self.faults and n != WEDGE}
            self.shot = Shot(replace(checked, text=source.text.edited(left)), open_store(cache))
        registry = Registry(source.text.path.parent / "nodes")
        self.types: dict[str, NodeType] = {n: registry.find(table["type"]) for n, table in self.tables.items()}

    def with_text(self, text: str) -> "Draft":
        """Return the draft of another text of the same file; BadInput as above."""
        source = replace(self._source, text=GraphText(self._source.text.path, text))
        return Draft(source, self.shot.cache)

    def saved_as(self, name: str) -> "Draft":
        """Write the text into a new file within the project; BadInput for another path, and for an existing file.

        name  path relative to the folder of the graph, or to the current folder for a shipped graph
        """
        try:
            path = ((Path.cwd() if self.shipped else self.shot.path.parent) / name).resolve()
            fits = path.suffix == ".toml" and not path.exists() and path.parent.is_dir()
        except (OSError, ValueError):  # too long, or not a name
            raise BadInput("not a path", where=name[:60], right="a name such as fringe.toml") from None
        Bounds(self.shot.graph, self.shot.cache).folder_of(path)
        if not fits:
            raise BadInput("not the path of a new graph", where=path, right="a name such as fringe.toml")
        draft = Draft(Source(GraphText(path, self.text)), self.shot.cache)
        draft.save(None)
        return draft

    def write_new(self, name: str, data: bytes) -> str:
        """Write a new file within the project, and return its path as given; BadInput as `saved_as`, and if shipped.

        name  path relative to the folder of the graph
        """
        if self.shipped:
            raise BadInput("not a file of yours", where=self._source.shipped, right="save as")
        path = (self.shot.path.parent / name).resolve()
        root = Bounds(self.shot.graph, self.shot.cache).folder_of(path)
        try:
            with entered(root, path.parent) as folder:
                write_whole(folder / path.name, data)
        except OSError as error:
            raise BadInput(f"cannot be written: {error.strerror}", where=path) from None
        return name

    @property
    def shipped(self) -> bool:
        """Whether the graph is installed with hairpipe, and cannot be saved in its place."""
        return self._source.shipped is not None

    def edges(self, node: str) -> dict[str, Edge]:
        """Return the edges of a node, which may be incomplete, by plug."""
        return read_edges(self.tables[node].get("in", {}), self.types[node], lambda names: node)

    def field(self, node: str, names: Sequence[str]) -> Field:
        """Return the group of settings of a name; BadInput for an unknown one."""
        found = field_at(self.types[node], names) if node in self.types else None
        if found is None or not found.group:
            raise BadInput(f"no group '{'.'.join(names)[:60]}'", where=node[:60], right="a group of settings")
        return found

    def read_file(self) -> str | None:
        """Read the text that the file has now; None for a missing one."""
        return read_graph_text(self.shot.path).text if self.shot.path.exists() else None

    def save(self, seen: str | None) -> None:
        """Write the text into the file; BadInput for a shipped graph, another text, and a file that cannot be written.

        seen  text that the file had when last read, None for none; a file that was deleted since is written again
        """
        if self.shipped:
            raise BadInput("not a file of yours", where=self._source.shipped, right="save as")
        path = self.shot.path
        try:
            with locked(path):
                if self.read_file() not in (None, seen):
                    raise BadInput("another program has changed the file", where=path, right="choose a version")
                save_text(path, self.text)
        except OSError as error:
            raise BadInput(f"cannot be written: {error.strerror}", where=self.shot.path) from None


def load_draft(given: str, text: str | None = None, *, cache: Path | str | None = None) -> Draft:
    """Read a graph that may be incomplete; BadInput as for `load`, otherwise.

    given  path of a file, or name of a shipped graph
    text   text in place of that of the file, which may not exist
    """
    folder = open_store(cache).root
    if text is not None and not Path(given).exists() and Path(given).suffix:
        return Draft(Source(GraphText(Path(given), text)), folder)
    source = read_source(given)
    return Draft(source if text is None else replace(source, text=GraphText(source.text.path, text)), folder)


def write_tables(path: Path, head: dict[str, Any], tables: dict[str, dict[str, Any]], owned: Sequence[str]) -> bool:
    """Write tables into a graph file, see `with_tables`; return whether the file has changed.

    A missing file is made, with its folder. BadInput, with the file untouched, where the text would not be a graph.
    """
    with locked(path):
        before = read_graph_text(path).text if path.exists() else None
        text = with_tables(SCHEMA if before is None else before, head, tables, owned)
        Source(GraphText(path, text)).graph()
        size = len(text.encode())
        if size > MOST_BYTES:
            raise BadInput(f"{size} bytes are too many for a graph", where=path, right=f"<= {MOST_BYTES}")
        if text != before:
            save_text(path, text)
    return text != before


def incomplete(text: GraphText) -> dict[str, str]:
    """Find the nodes that lack an input or a setting, and those that depend on them, with what is missing."""
    faults: dict[str, str] = {}
    tables = {name: table for name, table in text.tables.items() if name != WEDGE}
    while True:
        try:
            make_graph(text.edited(tables), empty=True)
        except Incomplete as fault:
            faults[fault.node] = f"{fault.what} ({fault.right})"
        else:
            return faults
        lost = [[*faults][-1]]
        for name in lost:
            tables.pop(name)
            for other, table in nodes_of(tables).items():
                if other not in faults and name in sources_of(table):
                    faults[other] = f"'{name}' is incomplete"
                    lost.append(other)


def sources_of(table: Mapping[str, Any]) -> set[str]:
    edges = table.get("in", {}).values()
    flat = [one for value in edges for one in (value if isinstance(value, list) else [value])]
    return {one.partition(".")[0] for one in flat}


def write_whole(path: Path, data: bytes) -> None:
    """Write a new file; OSError, and no file of it, where that fails."""
    with path.open("xb") as file:
        try:
            file.write(data)
            file.flush()
        except OSError:
            path.unlink()
            raise
