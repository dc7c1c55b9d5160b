"""Records tables that the graph of a run writes or collects, in a results file next to the graph."""

import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from hairpipe.api.reports import Run
from hairpipe.api.selection import fold_frames
from hairpipe.api.shot import Node, Record, Shot, Task
from hairpipe.data import Table
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.file import PROGRAM, Results, Value, ValueTable, results_path, write_results
from hairpipe.graphs.experiments.figures.provenance import commit_of, recording_machine, repository_of
from hairpipe.graphs.experiments.figures.recipe import recipe_of
from hairpipe.io.table import lay_below

WRITES, COLLECTS = "write_table", "collect_variants"
"""Types of nodes that end in a table: what one has collected is recorded unless the other writes it."""


class Recording:
    """Records one run of a graph; made before the run, so that nothing is computed in vain.

    name      of the results file, None for that of the graph file
    settings  that the command changes, as texts of the command line
    frames    that the command selects, None for all
    to        nodes that the command asks for

    BadInput where code is not committed, and where the graph has no table.
    """

    def __init__(
        self, shot: Shot, name: str | None, settings: Mapping[str, str], frames: Sequence[int] | None, to: Sequence[str]
    ) -> None:
        self.path = results_path(shot.path.parent, name or shot.path.stem)
        self._commit = commit_of(shot.path.parent)
        self._settings = dict(settings)
        self._frames = None if frames is None else fold_frames(frames)
        self._command = command_of(shot.path, self._settings, self._frames, to, name)
        self._nodes = table_nodes(shot.part(to).nodes)
        if not self._nodes:
            raise BadInput("no table to record", where=shot.path, right=f"a node {WRITES} or {COLLECTS}")

    def write(self, done: Run) -> None:
        """Write the tables of a run that has ended well; OSError where the file cannot be written."""
        shot = done.shot
        assert isinstance(shot, Shot)
        records = shot.results(done.frames, to=self._nodes)
        recipe = recipe_of(shot, done.frames, self._nodes)
        results = Results(
            commit=self._commit,
            machine=recording_machine(),
            command=self._command,
            graph=shot.path.name,
            settings=self._settings,
            frames=self._frames,
            module="",
            processor=round(seconds_of(records.values()), 2),
            tables={name: table_of(shot, done.graph.nodes[name], records) for name in self._nodes},
            nodes=recipe.nodes,
            shot=recipe.frames,
            modules=recipe.modules,
            python=recipe.python,
        )
        write_results(self.path, results)


def table_nodes(nodes: Mapping[str, Node]) -> list[str]:
    """Name the nodes that write a table, and those that collect one that none of these writes."""
    writing = [node for node in nodes.values() if node.type.name == WRITES]
    written = {edge.node for node in writing for edge in node.edges.values()}
    collecting = [node for node in nodes.values() if node.type.name == COLLECTS and node.name not in written]
    return [node.name for node in (*writing, *collecting)]


def table_of(shot: Shot, node: Node, records: Mapping[str, Record]) -> ValueTable:
    """Read the table that a node writes or collects, with the keys of the results that it is read from."""
    edges = list(node.edges.values())
    keys = {edge.node: records[edge.node].key for edge in edges}
    if node.type.name == COLLECTS:
        table = shot.read(Task(node.name, None), records[node.name])
    else:
        tables = [shot.read(Task(edge.node, None), records[edge.node], edge.output) for edge in edges]
        table = lay_below(tables, node.settings["cases"])
    return ValueTable(list(table.names), rows_of(table), keys)


def rows_of(table: Table) -> list[list[Value]]:
    """List the rows of a table; a number that is not finite has no value."""
    return [[None if isinstance(v, float) and not math.isfinite(v) else v for v in row] for row in table.rows()]


def seconds_of(records: Iterable[Record]) -> float:
    """Add up the seconds of the processor that results took, each once [s]."""
    spent = {record.key: record.seconds if record.processor is None else record.processor for record in records}
    return sum(spent.values())


def command_of(
    graph: Path, settings: Mapping[str, str], frames: str | None, to: Sequence[str], name: str | None
) -> str:
    """Write the command that computes and records the same again, in the root of the repository."""
    graph = graph.resolve()
    words = [*PROGRAM, "record", graph.relative_to(repository_of(graph.parent).resolve()).as_posix()]
    words += [word for target, value in settings.items() for word in ("--set", f"{target}={value}")]
    words += ["--frames", frames] if frames else []
    words += [word for node in to for word in ("--to", node)]
    return shlex.join([*words, *(["--name", name] if name else [])])
