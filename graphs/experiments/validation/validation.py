"""Validations: graphs whose tables `rows` and `quick` collect rows, with the cost of each."""

from collections.abc import Mapping
from dataclasses import dataclass

from hairpipe.app.api.shot import Node, Record, Shot, Task
from hairpipe.app.api.source import shipped_graphs
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.figures.file import read_results
from hairpipe.graphs.experiments.figures.recording import seconds_of
from hairpipe.graphs.experiments.validation.row import Row
from hairpipe.values import Table

ROWS, QUICK = "rows", "quick"
"""Names of the nodes that collect all rows, and those of a short run."""
PREFIX = "experiments/validate_"
PICTURE = ".png"
SOLVERS = "results/swing.json"
"""Recorded errors and costs of other solvers."""


@dataclass(frozen=True)
class Measured:
    """A row with its cost.

    seconds  processor time of all results that the case needs [s]; rows may share results
    """

    row: Row
    seconds: float


def shipped_validations() -> list[str]:
    """List the names of the validations of hairpipe; BadInput without any: only a clone has them."""
    found = [name for name in shipped_graphs() if name.startswith(PREFIX)]
    if not found:
        right = "hairpipe installed from a clone of its repository, or graphs of your own"
        raise BadInput("an installed wheel has no validations", right=right)
    return found


def collecting_node(shot: Shot, *, quick: bool) -> str | None:
    """Name the node that collects the rows; None for a validation without quick ones, BadInput for another graph."""
    if ROWS not in shot.nodes:
        raise BadInput(f"no node '{ROWS}'", where=shot.path, right=f"[{ROWS}], of tables of `check_errors`")
    wanted = QUICK if quick else ROWS
    return wanted if wanted in shot.nodes else None


def picture_nodes(shot: Shot, node: str) -> list[str]:
    """List the nodes that draw published pictures of nothing but what a node needs."""
    known = shot.part((node,)).nodes
    return [found.name for found in shot.nodes.values() if is_picture(found, known)]


def is_picture(node: Node, known: Mapping[str, Node]) -> bool:
    """Whether a node publishes a picture, and all its inputs are known."""
    published = node.publish is not None and node.publish.suffix == PICTURE
    return published and all(edge.node in known for edge in node.edges.values())


def measured_rows(shot: Shot, node: str) -> list[Measured]:
    """Read the rows that a node collects; those that have not been computed are left out."""
    records = shot.results(to=node)
    spent = processor_of(records)
    found = []
    for edge in shot.nodes[node].edges.values():
        if edge.node in records:
            table = shot.read(Task(edge.node, None), records[edge.node], edge.output)
            sources = [source.node for source in shot.nodes[edge.node].edges.values()]
            found += measured_cases(shot, table, sources, spent)
    return found


def measured_cases(shot: Shot, table: Table, sources: list[str], spent: Mapping[str, float]) -> list[Measured]:
    """Return the rows of a table, each of a source node, with their costs; BadInput for another table."""
    if table.names != Row._fields:
        what = f"a table of {', '.join(table.names)}"
        raise BadInput(what, where=shot.path, right=f"tables of `check_errors` in '{ROWS}' and '{QUICK}'")
    rows = [Row(*values) for values in table.rows()]
    return [
        Measured(row, sum(spent.get(name, 0.0) for name in shot.part((source,)).nodes))
        for row, source in zip(rows, sources, strict=True)
    ]


def processor_of(records: Mapping[str, Record]) -> dict[str, float]:
    """Sum the processor time of the results of every node, equal results once [s]."""
    by_node: dict[str, dict[str, Record]] = {}
    for target, record in records.items():
        by_node.setdefault(target.partition("@")[0], {})[record.key] = record
    return {node: seconds_of(found.values()) for node, found in by_node.items()}


def recorded_solvers() -> tuple[list[tuple[str, ...]], str]:
    """Return the table of solvers, its header first, and how it was recorded; BadInput where it is not installed."""
    found = read_results(shipped_graphs()[shipped_validations()[0]].parent / SOLVERS)
    table = found.tables["peers"]
    rows = [tuple(f"{value:.3g}" if isinstance(value, float) else str(value) for value in row) for row in table.rows]
    source = f"recorded at commit {found.commit[:7]} on {found.machine.processor} by `{found.command}`"
    return [tuple(line[1:]) for line in (tuple(table.columns), *rows)], source
