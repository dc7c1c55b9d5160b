"""Records tables of a run of a graph or a wedge, and their cost, in a results file.

Provenance of figures: the commit of the code, and the machine.
"""

import math
import os
import shlex
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hairpipe.app.api.reports import Run
from hairpipe.app.api.selection import fold_frames
from hairpipe.app.api.shot import Node, Record, Shot, Task, WedgeShot
from hairpipe.errors import BadInput
from hairpipe.formats.values import lay_below
from hairpipe.graphs.experiments.bench.machine import this_machine
from hairpipe.graphs.experiments.figures.file import (
    COST,
    FOLDER,
    Machine,
    Results,
    Value,
    ValueTable,
    results_path,
    write_results,
)
from hairpipe.graphs.experiments.figures.recipe import recipe_of
from hairpipe.processor import processor_class
from hairpipe.values import Table

LAYER = "threading layer"


def repository_of(folder: Path) -> Path:
    """Find the root of the git repository of a folder; BadInput if there is none."""
    return Path(git(folder, "rev-parse", "--show-toplevel"))


def commit_of(folder: Path) -> str:
    """Find the commit of the repository of a folder; BadInput if its code has uncommitted changes.

    Pages, films and results may have changes: no result depends on them.
    """
    found = git(folder, "status", "--porcelain", "--untracked-files=all", "--no-renames", "-z").split("\0")
    changed = [name for line in found if (name := line[3:]) and not is_written(name)]
    if changed:
        more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
        raise BadInput(f"uncommitted changes: {changed[0]}{more}", where=folder, right="figures of committed code")
    return git(folder, "rev-parse", "HEAD")


def is_written(name: str) -> bool:
    """Whether a file of a repository is a page, a film or a results file."""
    path = Path(name)
    return path.suffix in (".md", ".webp") or (path.suffix == ".json" and path.parent.name == FOLDER)


def recording_machine(bandwidth: float | None = None) -> Machine:
    """Describe this machine.

    bandwidth  of memory [GB/s], None if it was not measured
    """
    found = this_machine()
    versions = {name: version for name, version in found.versions.items() if name != LAYER}
    return Machine(found.processor, found.cores, bandwidth, processor_class(), found.versions[LAYER], versions)


def git(folder: Path, *words: str) -> str:
    """Return the output of git; BadInput if it fails or is missing."""
    try:
        done = subprocess.run(["git", "-C", folder, *words], capture_output=True, text=True, check=True)
    except FileNotFoundError:
        raise BadInput("git is not installed", where=folder, right="figures name the commit of the code") from None
    except subprocess.CalledProcessError:
        raise BadInput("not in a git repository", where=folder, right="figures name the commit of the code") from None
    return done.stdout.strip("\n")


WRITES, COLLECTS = "write_table", "collect_variants"
"""Types of nodes whose tables are recorded: collected tables only if they are not written."""


class Recording:
    """Records one run of a graph or of a wedge; built before the run, so that errors are found first.

    In addition, the table COST has a row for every node that the tables depend on, or without tables for every node of
    the run.

    name      of the results file, relative to the folder of the graph; None for that of the graph, and of the wedge
    settings  changed by the command, as texts of the command line
    frames    selected by the command, None for all
    to        nodes selected by the command

    BadInput if code is not committed.
    """

    def __init__(
        self,
        shot: Shot | WedgeShot,
        name: str | None,
        settings: Mapping[str, str],
        frames: Sequence[int] | None,
        to: Sequence[str],
    ) -> None:
        self._wedge = shot.definition.name if isinstance(shot, WedgeShot) else None
        default = "_".join(filter(None, (shot.path.stem, self._wedge)))
        self.path = results_path(shot.path.parent, name or default)
        self._commit = commit_of(shot.path.parent)
        self._settings = dict(settings)
        self._frames = None if frames is None else fold_frames(frames)
        self._command = command_of(shot.path, self._settings, self._frames, to, self._wedge, name)
        graph = shot.original if isinstance(shot, WedgeShot) else shot.graph
        self._tables = table_nodes((graph.upto(to) if to else graph).nodes)
        self._to = self._tables or list(to)

    def write(self, done: Run) -> None:
        """Write the tables of a successful run; OSError if the file cannot be written."""
        shot = done.shot
        assert isinstance(shot, Shot | WedgeShot)
        records = shot.results(done.frames, to=self._to)
        recipe = recipe_of(shot, done.frames, self._to)
        tables = {name: recorded_table(shot, name, records) for name in self._tables}
        results = Results(
            commit=self._commit,
            machine=recording_machine(),
            command=self._command,
            graph=os.path.relpath(shot.path, self.path.parent.parent),
            settings=self._settings,
            frames=self._frames,
            module="",
            processor=round(seconds_of(records.values()), 2),
            tables=tables | {COST: cost_table(records)},
            nodes=recipe.nodes,
            shot=recipe.frames,
            modules=recipe.modules,
            python=recipe.python,
            wedge=self._wedge,
            to=self._to,
        )
        write_results(self.path, results)


def cost_table(records: Mapping[str, Record]) -> ValueTable:
    """Sum the cost of results by node, each once: number, seconds, and size in the store."""
    by_node: dict[str, dict[str, Record]] = {}
    for target, record in records.items():
        by_node.setdefault(target.partition("@")[0], {})[record.key] = record
    rows: list[list[Value]] = []
    for node, found in by_node.items():
        objects = dict(item for record in found.values() for item in record.objects())
        passed = round(sum(record.seconds for record in found.values()), 2)
        megabytes = round(sum(objects.values()) / 1e6, 3)
        rows.append([node, len(found), passed, round(seconds_of(found.values()), 2), megabytes])
    return ValueTable(["node", "results", "seconds", "processor", "size [MB]"], rows, {})


def recorded_table(shot: Shot | WedgeShot, name: str, records: Mapping[str, Record]) -> ValueTable:
    """Read a table of a run; those of variants of a wedge are concatenated, with columns of the varied settings.

    Variants that ended before their table was computed have no rows.
    """
    if isinstance(shot, Shot):
        return table_of(shot, name, records)
    targets = list(shot.definition.axes)
    columns = targets
    rows: list[list[Value]] = []
    keys: dict[str, str] = {}
    for variant in shot.variants.values():
        node = variant.names[name]
        if node in records:
            table = table_of(shot, node, records)
            columns = [*targets, *table.columns]
            varied = [plain_value(variant.settings[target]) for target in targets]
            rows += [[*varied, *row] for row in table.rows]
            keys |= table.keys
    return ValueTable(columns, rows, keys)


def plain_value(value: Any) -> Value:
    """Return the value of a setting as a cell: a list or a group as text."""
    return value if isinstance(value, str | int | float | bool) else str(value)


def table_nodes(nodes: Mapping[str, Node]) -> list[str]:
    """List the nodes that write a table, and those whose collected table is not written."""
    writing = [node for node in nodes.values() if node.type.name == WRITES]
    written = {edge.node for node in writing for edge in node.edges.values()}
    collecting = [node for node in nodes.values() if node.type.name == COLLECTS and node.name not in written]
    return [node.name for node in (*writing, *collecting)]


def table_of(shot: Shot | WedgeShot, name: str, records: Mapping[str, Record]) -> ValueTable:
    """Read the written or collected table of a node, with the keys of its source results."""
    node = shot.graph.nodes[name]
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
    """Sum the processor time of results, each once [s]."""
    spent = {record.key: record.seconds if record.processor is None else record.processor for record in records}
    return sum(spent.values())


def command_of(
    graph: Path,
    settings: Mapping[str, str],
    frames: str | None,
    to: Sequence[str],
    wedge: str | None,
    name: str | None,
) -> str:
    """Return the command that repeats the recording, in the root of the repository."""
    graph = graph.resolve()
    words = ["hairpipe", "run", graph.relative_to(repository_of(graph.parent).resolve()).as_posix()]
    words += [word for target, value in settings.items() for word in ("--set", f"{target}={value}")]
    words += ["--frames", frames] if frames else []
    words += [word for node in to for word in ("--to", node)]
    words += ["--wedge", wedge] if wedge else []
    return shlex.join([*words, "--record", *([name] if name else [])])
