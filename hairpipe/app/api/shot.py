"""A shot: a graph that has been checked, with the cache of its results, or all variants of a wedge as one.

`load` makes one, and `Shot.wedge` another of all variants, of which common results are computed once.
"""

import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Self

from hairpipe.app.api.cache import open_store
from hairpipe.app.api.graph_shot import GraphShot, Stopping, read_table
from hairpipe.app.api.reports import Explanation
from hairpipe.app.api.selection import Names, read_names
from hairpipe.app.api.source import Given, Source, plain, read_source, shipped_graphs
from hairpipe.engine.file.graph import Edge, Graph, Node, merged, project_of, unvaried
from hairpipe.engine.file.overrides import WEDGE
from hairpipe.engine.file.wedge import Wedge, find_wedge, variant_name
from hairpipe.engine.node.declare import File
from hairpipe.engine.node.messages import nearest
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.run.player import Player, played_nodes
from hairpipe.engine.store.store import Record, Store
from hairpipe.engine.worker.machine_code import kernels_parent
from hairpipe.errors import BadInput
from hairpipe.values import Table

__all__ = ["Edge", "Explanation", "File", "Graph", "Node", "Player", "Record", "Shot", "Task", "Wedge", "load"]
__all__ += ["played_nodes", "project_of"]


@dataclass(frozen=True)
class Variant:
    """A variant of a wedge.

    settings  differences to the graph file, by `node.setting` or `node.group.setting`
    graph     the graph file with these settings, and unvaried inputs; its results have the same keys in the wedge
    names     names of its nodes in the graph of all variants, by their names in the graph file
    """

    name: str
    settings: dict[str, Any]
    graph: Graph
    names: dict[str, str]


class WedgeShot(GraphShot):
    """All variants of a wedge in one graph: equal nodes of several variants exist once.

    definition  of the wedge in the graph file
    original    the unchanged graph file
    variants    by name
    """

    def __init__(self, source: Source, store: Store, name: str) -> None:
        super().__init__(source, store)
        self.definition: Wedge = find_wedge(source.text, name)
        chosen = self.definition.variants
        tables = {name: table for name, table in source.text.tables.items() if name != WEDGE}
        alone = source.edited(tables)  # the wedges are checked once, not for every variant
        graphs = {label: self._graph_of(alone, label, settings) for label, settings in chosen.items()}
        self.original = self.graph
        varied = {target.partition(".")[0] for target in self.definition.axes}
        graphs = {label: unvaried(graph, self.original, varied) for label, graph in graphs.items()}
        self.graph, names = merged(graphs, self._name_of)
        self.variants = {label: Variant(label, chosen[label], graphs[label], names[label]) for label in graphs}
        self._check_stop()

    def part(self, to: Names) -> Graph:
        """Return the graph of all variants, or the part of it up to some nodes.

        Measures of criteria that stop variants are always part of it.

        to  names in the graph file, for all variants, or names in the graph of all variants
        """
        given = read_names(to)
        names = {name: None for name in given if name in self.graph.nodes and name not in self.original.nodes}
        wanted = [self.original.node(name).name for name in given if name not in names]
        users = [v for v in self.variants.values() if wanted or not names.keys().isdisjoint(v.names.values())]
        judged = [criterion.node for criterion in self.definition.stop] if given else []
        names |= {variant.names[name]: None for name in [*wanted, *judged] for variant in users}
        return self.graph.upto(names) if names else self.graph

    def variant(self, name: str) -> Variant:
        """Find a variant; BadInput with the nearest name for a missing one."""
        if name not in self.variants:
            right = nearest(name, list(self.variants))
            raise BadInput(f"'{self.definition.name}' has no variant '{name}'", where=self.path, right=right)
        return self.variants[name]

    def task(self, variant: Variant, node: str, frame: int | None) -> Task:
        """Return the task of a variant's node in the graph of all variants; a value for the shot has no frame."""
        found = self.graph.nodes[variant.names[self.original.node(node).name]]
        return Task(found.name, frame if found.per_frame else None)

    def size_of(self, records: Iterable[Record]) -> int:
        """Return the size of results, each object once, without states of simulations that were not kept [bytes]."""
        sizes = {name: size for record in records for name, size in record.objects()}
        return sum(size for name, size in sizes.items() if self._store.has(name))

    def table(self, task: Task, record: Record) -> Table:
        """Read a result that is a table; BadInput for any other."""
        return read_table(self.graph, self._store, task, record)

    def stopping(self) -> Stopping:
        names = {label: variant.names for label, variant in self.variants.items()}
        return Stopping(self.graph, self._store, self.definition.stop, names)

    def _of(self, source: Source) -> Self:
        return type(self)(source, self._store, self.definition.name)

    def _graph_of(self, source: Source, label: str, settings: dict[str, Any]) -> Graph:
        try:
            return source.changed(settings).graph()
        except BadInput as fault:
            where = f"[wedge.{self.definition.name}] {label}: {fault.where}"
            raise BadInput(fault.what, where=where, right=fault.right) from None

    def _name_of(self, labels: Sequence[str]) -> str:
        """Name variants after their common settings."""
        axes = self.definition.axes
        first = self.definition.variants[labels[0]]
        alike = [target for target in axes if all(self.definition.variants[o][target] == first[target] for o in labels)]
        return variant_name(self.definition.short_names, {target: first[target] for target in alike})

    def _check_stop(self) -> None:
        """Raise BadInput for a criterion on a node without a value per frame."""
        for criterion in self.definition.stop:
            node = self.original.nodes[criterion.node]
            if not node.per_frame:
                what = f"stop: '{node.name}' has one value for the shot"
                where = f"{self.path}: [wedge.{self.definition.name}]"
                right = "a measure of every frame: watch_hair"
                raise BadInput(what, where=where, right=right)


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


FRAMES = 2  # number of computed frames: the first of a simulation is its start, and the second its first step
NOTICE = "kernels are compiled, once, in about a minute (`hairpipe warm` compiles them ahead)"
OURS = "hairpipe.nodes."


def shots_to_warm() -> list[str]:
    """List the shipped graphs that are shots: those that are in no folder of examples or experiments."""
    return [name for name in shipped_graphs() if "/" not in name]


@contextmanager
def warming(shot: Shot) -> Iterator[tuple[Shot, list[int]]]:
    """Yield the shot without published files, in a temporary folder of results, and the frames to run."""
    begin = shot.graph.begin
    with tempfile.TemporaryDirectory(prefix="hairpipe-") as folder:
        yield (
            load(shot.unpublished().tables, cache=folder, folder=shot.path.parent),
            list(range(begin, min(begin + FRAMES, shot.graph.frames[1] + 1))),
        )


def compiles_first(graph: Graph) -> bool:
    """Whether a run of a graph compiles kernels since this user has none: it has nodes of the house."""
    with suppress(OSError):  # no home: kernels are not kept
        if next(kernels_parent().glob("*/*.nbc"), None) is not None:
            return False
    return any(node.type.module.startswith(OURS) for node in graph.nodes.values())
