"""All variants of a wedge as one shot: common results are computed once. `Shot.wedge` makes one."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Self

from hairpipe.app.api.graph_shot import GraphShot, Stopping, read_table
from hairpipe.app.api.selection import Names, read_names
from hairpipe.app.api.source import Source
from hairpipe.engine.file.graph import Graph, merged, unvaried
from hairpipe.engine.file.overrides import WEDGE
from hairpipe.engine.file.wedge import Wedge, find_wedge, variant_name
from hairpipe.engine.node.messages import nearest
from hairpipe.engine.plan.planner import read_value
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.store.record import Record
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.values import Table

__all__ = ["Variant", "WedgeShot"]


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

    def value(self, task: Task, record: Record | None, output: str | None = None) -> Any:
        """Read a result; BadInput where it has not been computed.

        record  of the task, as `results` gives it
        output  of a node with several; without one, the only one or the first
        """
        return read_value(self.graph, self._store, task, record, output)

    def size_of(self, records: Iterable[Record]) -> int:
        """Return the size of results, each object once, without states of simulations that were not kept [bytes]."""
        sizes = {name: size for record in records for name, size in record.objects()}
        return sum(size for name, size in sizes.items() if self._store.has(name))

    def table(self, task: Task, record: Record) -> Table:
        """Read a result that is a table; BadInput for any other."""
        return read_table(self.graph, self._store, task, record)

    def stopping(self) -> Stopping:
        """Return the criteria that stop variants during a run."""
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
