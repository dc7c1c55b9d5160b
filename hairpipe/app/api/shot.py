"""A shot: a graph that has been checked, with the cache of its results. `load` makes one.

Compilation ahead of the first run: the first frames of a graph, computed in a temporary folder and discarded.
"""

import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, Self

from hairpipe.app.api.cache import open_store
from hairpipe.app.api.explanation import Explanation
from hairpipe.app.api.graph_shot import GraphShot
from hairpipe.app.api.source import Given, plain, read_source, shipped_graphs
from hairpipe.app.api.wedge_shot import WedgeShot
from hairpipe.engine.file.graph import Edge, Graph, Node, project_of
from hairpipe.engine.file.wedge import Wedge
from hairpipe.engine.node.signature import File
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.player import Player, played_nodes
from hairpipe.engine.store.record import Record
from hairpipe.engine.worker.machine_code import kernels_parent
from hairpipe.errors import BadInput

__all__ = [
    "Edge",
    "Explanation",
    "File",
    "Graph",
    "Node",
    "Player",
    "Record",
    "Shot",
    "Task",
    "Wedge",
    "load",
    "played_nodes",
    "project_of",
]


def load(
    graph: Given,
    set: Mapping[str, Any] | None = None,
    *,
    cache: str | os.PathLike[str] | None = None,
    folder: str | os.PathLike[str] | None = None,
) -> "Shot":
    """Read and check a graph; BadInput for the first fault in it, with file and line.

    graph   path of a file; as a str without a newline, path of a file or name of a shipped graph; as a str with a
            newline, the text of a graph; as a mapping, its tables
    set     settings to change, by `node.setting` or `node.group.setting`
    cache   folder of results; by default HAIRPIPE_CACHE, or `cache` in the current folder
    folder  folder of a text or of tables, the current folder by default: files, the folder `nodes`, and published files
            are relative to it. Files are published below it, or below the parent of a folder `graphs` that contains it

    Untrusted, which is a BadInput, for a graph with code that is not trusted: see `hairpipe trust`.
    """
    source = read_source(graph, folder)
    return Shot(source.changed(set) if set else source, open_store(cache))


class Shot(GraphShot):
    """A checked graph file with the cache of its results. It does not change: `changed` makes another one.

    graph  graph of the engine
    """

    @property
    def given(self) -> str:
        """Name or path by which `load` finds the graph, without changes; BadInput for one that has no file."""
        return self._source.given

    @property
    def wedges(self) -> dict[str, Wedge]:
        """The wedges of the graph file, by name: axes, and the settings of every variant."""
        return self._source.wedges

    def wedge(self, name: str) -> WedgeShot:
        """Return a shot of all variants of a wedge in one graph; BadInput for a missing wedge or a bad variant."""
        return WedgeShot(self._source, self._store, name)

    def save(self, set: Mapping[str, Any]) -> None:
        """Write settings into the graph file, by `node.setting` or `node.group.setting`, and change nothing else.

        BadInput for a setting that the graph refuses, and for a shipped graph.
        """
        from hairpipe.engine.edit import save_settings

        self.changed(set)
        if self._source.shipped is not None or not self.path.is_file():
            raise BadInput("not a file of yours", where=self._source.shipped or self.path, right="a copy of the graph")
        save_settings(self.path, plain(set))

    def graphs(self) -> list[Graph]:
        """Return the graph, and those of its wedges."""
        return [self.graph, *(self.wedge(name).graph for name in self.wedges)]

    def reloaded(self) -> Self:
        """Return the shot of the present file, without changes; BadInput as for `load`."""
        return self._of(read_source(self.given))


FRAMES = 2
"""Number of computed frames: the first of a simulation is its start, and the second its first step."""
NOTICE = "kernels are compiled, once, in about a minute (`hairpipe warm` compiles them ahead)"
OURS = "hairpipe.nodes."


def shots_to_warm() -> list[str]:
    """List the shipped graphs that are shots: those that are in no folder of examples or experiments."""
    return [name for name in shipped_graphs() if "/" not in name]


@contextmanager
def warming(shot: Shot) -> Iterator[tuple[Shot, list[int]]]:
    """Yield the shot without published files, in a temporary folder of results, and the frames to run."""
    tables = {
        name: {key: value for key, value in table.items() if key != "publish"} if isinstance(table, dict) else table
        for name, table in shot.tables.items()
    }
    begin = shot.graph.begin
    with tempfile.TemporaryDirectory(prefix="hairpipe-") as folder:
        yield (
            load(tables, cache=folder, folder=shot.path.parent),
            list(range(begin, min(begin + FRAMES, shot.graph.frames[1] + 1))),
        )


def compiles_first(graph: Graph) -> bool:
    """Whether a run of a graph compiles kernels since this user has none: it has nodes of the house."""
    with suppress(OSError):  # no home: kernels are not kept
        if next(kernels_parent().glob("*/*.nbc"), None) is not None:
            return False
    return any(node.type.module.startswith(OURS) for node in graph.nodes.values())
