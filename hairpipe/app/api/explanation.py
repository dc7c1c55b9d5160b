"""Explanation of one result: an object, whose text is a table."""

import json
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from hairpipe.app.api.formatting import duration, size, table
from hairpipe.engine.node.messages import one_line
from hairpipe.engine.plan import planner
from hairpipe.engine.store.record import Record

__all__ = ["Explanation"]

VERDICTS = {"cached": "cached", "run": "will run", "depends": "depends on"}


@dataclass(frozen=True, repr=False)
class Explanation(planner.Explanation):
    """The plan of one task in detail, printed as a table of settings, inputs and outputs; fields as in the planner."""

    def __repr__(self) -> str:
        """Write the planned state of the task with its reason, the parts of its key, and its result if there is one."""
        status = self.entry.status
        why = self.reasons if self.entry.status != "cached" else ()
        lines = [f"{self.entry.task}: {VERDICTS[status]}" + (f" {why[0]}" if status == "depends" else "")]
        lines += [f"  {reason}" for reason in why] if status == "run" else []
        if self.parts is not None:
            lines += ["", table(list(made_of(self.parts)), "<<<")]
        if self.record is not None:
            lines += ["", table(outputs(self.record, self.thinned), "<>>"), "", evaluated(self.record)]
        return "\n".join(lines)

    def document(self) -> dict[str, Any]:
        """Describe the result as a JSON document."""
        record = self.record
        kept = {} if record is None else record.outputs
        return self.entry.task._asdict() | {
            "status": self.entry.status,
            "reasons": [] if self.entry.status == "cached" else list(self.reasons),
            "key": self.entry.key,
            "made_of": self.parts,
            "outputs": record and {n: o._asdict() | {"kept": n not in self.thinned} for n, o in kept.items()},
            "seconds": record and record.seconds,
            "processor": record and record.processor,
            "created": record and record.created,
            "processor_class": record and record.processor_class,
            "threading_layer": record and record.threading_layer,
            "warnings": list(record.warnings) if record else [],
        }


def made_of(parts: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    yield "type", parts["type"], ""
    yield "code", "", parts["code"]
    yield from (("setting", name, text) for name, text in spread(parts["settings"]))
    yield from (("input", name, written(value)) for name, value in parts["inputs"].items())
    yield from (("time", name, str(value)) for name, value in (parts["time"] or {}).items())


def spread(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """List settings by dotted name, as in a graph file; an omitted group is absent."""
    for name, value in settings.items():
        if isinstance(value, Mapping):
            yield from spread(value, f"{prefix}{name}.")
        else:
            yield prefix + name, "absent" if value is None else json.dumps(value)


def written(value: Any) -> str:
    """Write the objects of a socket: one, those of the previous and the current frame, or the number of frames."""
    if value is None:
        return "not connected"
    if not isinstance(value, list):
        return value
    if isinstance(value[0], str):
        previous, current = value
        return f"{current} (previous frame: {'the same' if previous == current else previous})"
    return f"{len(value)} frames"


def outputs(record: Record, thinned: frozenset[str]) -> list[tuple[str, str, str]]:
    sizes = {name: "not kept" if name in thinned else size(output.size) for name, output in record.outputs.items()}
    return [(f"output {name}".rstrip(), sizes[name], output.object) for name, output in record.outputs.items()]


def evaluated(record: Record) -> str:
    when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.created))
    on = f" on {record.processor_class}" if record.processor_class else ""
    on += f", threads by {record.threading_layer}" if record.threading_layer else ""
    busy = "" if record.processor is None else f", processor {duration(record.processor)}"
    warnings = [one_line(f"warning: {warning}") for warning in record.warnings]
    return "\n".join([f"computed {when} in {duration(record.seconds)}{on}{busy}", *warnings])
