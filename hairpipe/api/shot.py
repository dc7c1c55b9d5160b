"""A shot: a graph that has been checked, with the cache of its results. `load` makes one."""

import os
from collections.abc import Mapping
from typing import Any, Self

from hairpipe.api.cache import open_store
from hairpipe.api.explanation import Explanation
from hairpipe.api.graph_shot import GraphShot
from hairpipe.api.source import Given, plain, read_source
from hairpipe.api.wedge_shot import WedgeShot
from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Edge, Graph, Node, project_of
from hairpipe.graph.file.wedge import Wedge
from hairpipe.graph.node.signature import File
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.run.player import Player, played_nodes
from hairpipe.graph.store.record import Record

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
        from hairpipe.graph.edit.saving import save_settings

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
