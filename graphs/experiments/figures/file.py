"""A results file: tables of measured values, the machine, and digests of the inputs.

It is in the folder `results` next to its graph or page. Only commands write it: a digest of the file reveals manual
changes.
"""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from hairpipe.engine.store.atomic import write_text
from hairpipe.engine.store.digest import digest, digest_bytes, parsed
from hairpipe.errors import BadInput
from hairpipe.plain_file import content

FORMAT = 1
FOLDER = "results"
COST = "cost of nodes"
"""Name of the table of costs; no node has this name."""
RIGHT = "a file that `hairpipe run GRAPH --record` has written"
Value = str | int | float | bool | None


@dataclass(frozen=True)
class Machine:
    """Machine of a measurement.

    bandwidth  of memory [GB/s], None if it was not measured
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
    rows     values by column; None for a number that is not finite
    keys     keys of the source results, by name of the node
    """

    columns: list[str]
    rows: list[list[Value]]
    keys: dict[str, str]


@dataclass(frozen=True)
class Results:
    """Measurements of one command.

    commit     of the code, in full
    command    that repeats the measurement
    graph      path of the graph file relative to the parent folder, None without a graph
    settings   changed by the command, as texts of the command line, by target
    frames     selected by the command, None for all
    module     of a measurement without a graph, empty otherwise
    processor  processor time of the results [s]
    nodes, shot, modules, python  as in a recipe of the engine; without a graph, nodes are files by path and digest
    wedge      name of the wedge whose variants were run; None for the graph alone
    to         recorded nodes; none for those of the tables, or for all if there are no tables
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
    """Digest an input file; BadInput if it cannot be read."""
    return digest_bytes("file", content(path, "the file that was measured with"))


def results_path(folder: Path, name: str) -> Path:
    """Return the path of a results file, relative to a folder; the name may contain another folder."""
    return folder / Path(name).parent / FOLDER / f"{Path(name).name}.json"


def write_results(path: Path, results: Results) -> None:
    """Write a results file atomically, with a line per row of a table; OSError if it cannot be written."""
    fields = asdict(results)
    document = {"format": FORMAT, **fields, "check": digest("results", fields)}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, laid_out(document) + "\n")


def read_results(path: Path) -> Results:
    """Read a results file; BadInput if it is missing, damaged or was changed manually."""
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
    """Build results from their JSON fields; TypeError for missing or unknown ones."""
    tables = {name: ValueTable(**table) for name, table in fields["tables"].items()}
    return Results(**fields | {"machine": Machine(**fields["machine"]), "tables": tables})


def laid_out(value: Any, margin: str = "") -> str:
    """Return JSON with a line for each field of an object, and for each row of a table; pure."""
    inner = f"{margin} "
    if isinstance(value, dict) and value:
        lines = [f"{inner}{json.dumps(name)}: {laid_out(item, inner)}" for name, item in value.items()]
        return "{\n" + ",\n".join(lines) + f"\n{margin}}}"
    if isinstance(value, list) and value and isinstance(value[0], list):
        return "[\n" + ",\n".join(f"{inner}{json.dumps(row)}" for row in value) + f"\n{margin}]"
    return json.dumps(value)
