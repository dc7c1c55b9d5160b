"""`hairpipe explain`: the inputs of one result, and its differences to the latest one."""

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import hairpipe
from hairpipe.api.formatting import duration, size, table
from hairpipe.cli import options
from hairpipe.graph.node.messages import one_line

if TYPE_CHECKING:
    from hairpipe.api.selection import Target
    from hairpipe.api.shot import Explanation, Record


@click.command()
@options.graph
@options.target
@options.frames
@options.overrides
@options.cache
@options.as_json
def explain(
    graph: str,
    target: "Target",
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    cache: Path,
    as_json: bool,
) -> None:
    """Explain one result: inputs, state, what is different.

    The result is that of a node at a frame, `hair@12`, or of a node that has one value for the shot, `groom`.
    """
    found = hairpipe.load(graph, options.parsed(overrides), cache=cache).explain(target, frames=frames)
    click.echo(json.dumps(document(found), indent=2) if as_json else text(found))


def text(found: "Explanation") -> str:
    """Write an explanation."""
    status = {"cached": "cached", "run": "will run", "depends": "depends on"}[found.entry.status]
    why = reasons(found)
    lines = [f"{found.entry.task}: {status}" + (f" {why[0]}" if status == "depends on" else "")]
    lines += [f"  {reason}" for reason in why] if status == "will run" else []
    if found.parts is not None:
        lines += ["", table(made_of(found.parts), "<<<")]
    if found.record is not None:
        lines += ["", table(outputs(found.record, found.thinned), "<>>"), "", evaluated(found.record)]
    return "\n".join(lines)


def reasons(found: "Explanation") -> list[str]:
    """List the reasons why a result is not in the cache."""
    return [] if found.entry.status == "cached" else list(found.reasons)


def made_of(parts: dict[str, Any]) -> list[tuple[str, str, str]]:
    """List what a key is made of: kind, name, value or digest."""
    rows = [("type", parts["type"], ""), ("code", "", parts["code"])]
    rows += [("setting", name, json.dumps(value)) for name, value in parts["settings"].items()]
    rows += [("input", name, spoken(value)) for name, value in parts["inputs"].items()]
    return rows + [("time", name, str(value)) for name, value in (parts["time"] or {}).items()]


def spoken(value: Any) -> str:
    """Write what goes into a socket: an object, the previous and the current one, or one per frame."""
    if value is None:
        return "not connected"
    if isinstance(value, list):
        return " then ".join(value) if isinstance(value[0], str) else f"{len(value)} frames"
    return value


def outputs(record: "Record", thinned: frozenset[str]) -> list[tuple[str, str, str]]:
    """List the outputs of a result: name, size, object."""
    sizes = {name: "not kept" if name in thinned else size(output.size) for name, output in record.outputs.items()}
    return [("output " + name, sizes[name], output.object) for name, output in record.outputs.items()]


def evaluated(record: "Record") -> str:
    """Write when a result was computed, in how long, and with which warnings."""
    when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.created))
    on = f" on {record.processor_class}" if record.processor_class else ""
    on += f", threads by {record.threading_layer}" if record.threading_layer else ""
    return "\n".join(
        [f"computed {when} in {duration(record.seconds)}{on}", *(one_line(f"warning: {w}") for w in record.warnings)]
    )


def document(found: "Explanation") -> dict[str, Any]:
    """Describe an explanation as a JSON document."""
    record = found.record
    return found.entry.task._asdict() | {
        "status": found.entry.status,
        "reasons": reasons(found),
        "key": found.entry.key,
        "made_of": found.parts,
        "outputs": {n: o._asdict() | {"kept": n not in found.thinned} for n, o in record.outputs.items()}
        if record
        else None,
        "seconds": record.seconds if record else None,
        "created": record.created if record else None,
        "processor_class": record.processor_class if record else None,
        "threading_layer": record.threading_layer if record else None,
        "warnings": list(record.warnings) if record else [],
    }
