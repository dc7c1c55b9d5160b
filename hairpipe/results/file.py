"""A results file: tables of measured values, what they were measured with, and what they were made of.

It lies in the folder `results` next to the graph or the page that it belongs to. Only commands write it: a digest of
the whole reveals changes by hand.
"""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.store.atomic import write_text
from hairpipe.graph.store.digest import digest, digest_bytes, parsed
from hairpipe.plain_file import content

FORMAT = 1
FOLDER = "results"
COST = "cost of nodes"
"""Table of what the others have cost; no node has this name."""
RIGHT = "a file that `hairpipe run GRAPH --record` has written"
Value = str | int | float | bool | None


@dataclass(frozen=True)
class Machine:
    """Machine of a measurement.

    bandwidth  of its memory [GB/s], None where it was not measured
    kind       class of the processor, as `hairpipe version` names it
    layer      threading layer of numba
    versions   of Python and libraries, by name
    """

    processor: str
    cores: int
    bandwidth: float | None
    kind: str
    layer: str
    versions: dict[str, str]


@dataclass(frozen=True)
class ValueTable:
    """A table of measured values.

    columns  names with units
    rows     values by column; None where a number is not finite
    keys     of the results that it was read from, by name of the node
    """

    columns: list[str]
    rows: list[list[Value]]
    keys: dict[str, str]


@dataclass(frozen=True)
class Results:
    """Measurements of one command.

    commit     of the code, in full
    command    that measures the same again
    graph      path of the graph file from the folder above, None for what no graph has made
    settings   that the command has changed, as texts of the command line, by target
    frames     that the command has selected, None for all
    module     that has measured where no graph did, empty otherwise
    processor  seconds of the processor that the results cost [s]
    nodes, shot, modules, python  as in a recipe of the engine; without a graph, nodes are files by path and digest
    wedge      name of the wedge of which all variants were run; None for the graph alone
    to         nodes that were recorded; none for those of the tables, or where there are no others for all
    """

    commit: str
    machine: Machine
    command: str
    graph: str | None
    settings: dict[str, str]
    frames: str | None
    module: str
    processor: float
    tables: dict[str, ValueTable]
    nodes: dict[str, str]
    shot: str
    modules: dict[str, str]
    python: str
    wedge: str | None = None
    to: list[str] = field(default_factory=list)


def file_digest(path: Path) -> str:
    """Digest the bytes of a file that results depend on; BadInput where it cannot be read."""
    return digest_bytes("file", content(path, "the file that was measured with"))


def results_path(folder: Path, name: str) -> Path:
    """Return where results of a name lie, relative to a folder; the name may lead to another folder."""
    return folder / Path(name).parent / FOLDER / f"{Path(name).name}.json"


def write_results(path: Path, results: Results) -> None:
    """Write a results file whole or not at all, a row of a table on a line; OSError where it cannot be written."""
    fields = asdict(results)
    document = {"format": FORMAT, **fields, "check": digest("results", fields)}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, laid_out(document) + "\n")


def read_results(path: Path) -> Results:
    """Read a results file; BadInput where there is none, or where it is damaged or was changed by hand."""
    try:
        fields = parsed(content(path, RIGHT))
        version, check = fields.pop("format"), fields.pop("check")
        if version == FORMAT and check == digest("results", fields):
            return from_fields(fields)
    except (ValueError, TypeError, KeyError, AttributeError):
        raise BadInput("it is not a results file, or is damaged", where=path, right=RIGHT) from None
    what = "it was changed by hand" if version == FORMAT else f"its format is {version}, not {FORMAT}"
    raise BadInput(what, where=path, right=RIGHT)


def from_fields(fields: dict[str, Any]) -> Results:
    """Build results from their fields as in JSON; TypeError for missing or unknown ones."""
    tables = {name: ValueTable(**table) for name, table in fields["tables"].items()}
    return Results(**fields | {"machine": Machine(**fields["machine"]), "tables": tables})


def laid_out(value: Any, margin: str = "") -> str:
    """Write JSON with a line for each field of an object, and for each row of a table; pure."""
    inner = f"{margin} "
    if isinstance(value, dict) and value:
        lines = [f"{inner}{json.dumps(name)}: {laid_out(item, inner)}" for name, item in value.items()]
        return "{\n" + ",\n".join(lines) + f"\n{margin}}}"
    if isinstance(value, list) and value and isinstance(value[0], list):
        return "[\n" + ",\n".join(f"{inner}{json.dumps(row)}" for row in value) + f"\n{margin}]"
    return json.dumps(value)
