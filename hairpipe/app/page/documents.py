"""Graph and state of its results, as documents for the browser."""

import platform
import shutil
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from hairpipe import __version__
from hairpipe.app.api.draft import Draft
from hairpipe.app.api.graph_shot import GraphShot
from hairpipe.app.api.node_types import FOLDER, RESERVED, Field, NodeType, Registry, fields_of, fields_within
from hairpipe.app.api.node_types import document as type_document
from hairpipe.app.api.reports import Plan, Run, Status, Task
from hairpipe.app.api.selection import FrameSet, fold_frames
from hairpipe.app.api.shot import Edge, Record, WedgeShot
from hairpipe.app.page.values import kinds_of
from hairpipe.app.wedge import compare
from hairpipe.app.wedge import document as comparison_document
from hairpipe.engine.edit import sources_of
from hairpipe.errors import BadInput

Suffix = Callable[[str], str | None]  # finds the suffix of a picture by the name of its object; None for any other file
NAMED = 10  # number of shown letters of the name of an object


def graph_document(shot: GraphShot) -> dict[str, Any]:
    """Describe a graph: its nodes in order, with sockets, edges, settings and help."""
    tables = shot.tables
    return {
        "name": shot.path.stem,
        "file": shot.path.name,
        "frames": list(shot.graph.frames),
        "begin": shot.graph.begin,
        "fps": shot.fps,
        "nodes": [
            node_document(node.name, node.type, tables[node.name], node.edges, node.settings, node.publish)
            for node in shot.graph.nodes.values()
        ],
        "types": {node.type.name: type_document(node.type) for node in shot.graph.nodes.values()},
    }


def draft_document(draft: Draft) -> dict[str, Any]:
    """Describe a graph that is being edited: also incomplete and muted nodes, and positions."""
    document = graph_document(draft.shot)
    nodes = document["nodes"]
    for name, table in draft.tables.items():
        if name not in draft.shot.graph.nodes:
            kind = draft.types[name]
            settings = unchecked_settings(fields_of(kind), given_in(table))
            nodes.append(node_document(name, kind, table, draft.edges(name), settings, table.get("publish")))
    texts = sources_of(draft.text)
    for node in nodes:
        name = node["name"]
        node |= {"muted": name in draft.muted, "fault": draft.faults.get(name), "text": texts[name]}
    types = {found.name: type_document(found) for found in draft.types.values()}
    return document | {"types": types, "preroll": draft.shot.graph.preroll, "layout": dict(draft.layout)}


def node_document(
    name: str,
    kind: NodeType,
    table: Mapping[str, Any],
    edges: Mapping[str, Edge],
    settings: Mapping[str, Any],
    publish: Path | str | None,
) -> dict[str, Any]:
    return {
        "name": name,
        "type": kind.name,
        "doc": paragraphs(kind.function.__doc__ or ""),
        "edges": [{"plug": plug, "node": edge.node, "output": edge.output} for plug, edge in edges.items()],
        "settings": settings,
        "given": given_in(table),
        "publish": publish.name if isinstance(publish, Path) else publish,
        "per_frame": kind.mode != "once",
        "kinds": {output: kinds_of(found) for output, found in kind.outputs.items()},
    }


def given_in(table: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in table.items() if name not in RESERVED}


def unchecked_settings(fields: Iterable[Field], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the given settings with defaults, without a check."""
    found: dict[str, Any] = {}
    for field in fields:
        value = given.get(field.name)
        default = None if field.required or field.default is None else field.default
        if field.group and (isinstance(value, dict) or (value is None and default is not None)):
            found[field.name] = unchecked_settings(fields_within(field), value or {})
        else:
            plain = str(default) if isinstance(default, Path) else None if field.group else default
            found[field.name] = plain if value is None or (value is False and field.group) else value
    return found


def catalogue_document(path: Path) -> dict[str, Any]:
    """Describe all node types that a graph file can use; those that cannot be loaded are left out."""
    registry = Registry(path.parent / FOLDER)
    types = list[dict[str, Any]]()
    for name in registry.names():
        with suppress(BadInput):
            types.append(type_document(registry.find(name)))
    return {"types": types}


def paragraphs(text: str) -> str:
    """Return the text of a docstring before its list of settings."""
    kept: list[str] = []
    for line in text.strip().splitlines():
        if "  " in line.strip():
            break
        kept.append(line.strip())
    return "\n".join(kept).strip()


class RunOutput(NamedTuple):
    """Output of a run, finished or in progress."""

    statuses: Mapping[Task, Status]  # of the tasks that it has reached
    failures: Mapping[Task, str]  # messages of those that failed
    hosts: Mapping[Task, str] = MappingProxyType({})  # machines of the tasks that any process computes now


NOTHING = RunOutput({}, {})


def output_of(run: Run | None) -> RunOutput:
    """Return the output of a run; empty without a run."""
    return RunOutput(run.statuses, {failure.task: failure.message for failure in run.failures}) if run else NOTHING


def state_document(shot: GraphShot, found: Plan, suffix: Suffix, output: RunOutput = NOTHING) -> dict[str, Any]:
    """Describe the cached results, and the planned computation with reasons or the results of a run.

    found  plan of the shot
    """
    return {
        "nodes": nodes_document(shot, found, suffix, output),
        "verdict": verdict(shot, found, output),
        "wedge": False,
    }


def wedge_document(wedge: WedgeShot, plan: Plan, suffix: Suffix, output: RunOutput, frames: FrameSet) -> dict[str, Any]:
    """Describe the variants of a wedge: settings and measures of each, state of its results, and a verdict.

    plan    plan of the wedge
    frames  of the run that has computed it
    """
    nodes = nodes_document(wedge, plan, suffix, output)
    rows = comparison_document(wedge, compare(wedge, frames))["variants"]
    return {
        "name": wedge.definition.name,
        "names": list(wedge.definition.short_names.values()),
        "targets": list(wedge.definition.short_names),
        "joint": wedge.definition.joint,
        "show": wedge.definition.show or [list(wedge.original.nodes)[-1]],
        "variants": [{"name": row.pop("variant"), **row} for row in rows],
        "states": [{name: nodes[other] for name, other in v.names.items()} for v in wedge.variants.values()],
        "verdict": verdict(wedge, plan, output, f" --wedge {wedge.definition.name}"),
    }


def nodes_document(shot: GraphShot, found: Plan, suffix: Suffix, output: RunOutput) -> dict[str, Any]:
    """Describe the results of every node, a cell for the shot or for each frame."""
    nodes: dict[str, dict[str, Any]] = {name: {"cells": []} for name in shot.graph.nodes}
    for entry in found:
        state: str = entry.status
        status = output.statuses.get(entry.task)
        if status is not None and (state == "cached" or status in ("running", "failed")):
            state = status
        elif output.failures and status is None and state != "cached":
            state = "blocked"
        cell: dict[str, Any] = {"frame": entry.task.frame, "state": state, "reason": entry.reason}
        if entry.task in output.hosts:
            cell |= {"state": "running", "reason": f"on {output.hosts[entry.task]}"}
        if entry.task in output.failures:
            cell["reason"] = output.failures[entry.task]
        record = found.records.get(entry.task)
        if record is not None:
            cell |= measured(record, suffix)
        nodes[entry.task.node]["cells"].append(cell)
    return nodes


def measured(record: Record, suffix: Suffix) -> dict[str, Any]:
    """Describe a result: wall-clock and processor time, bytes, warnings, objects of its outputs."""
    pictures = {name: suffix(output.object) for name, output in record.outputs.items()}
    return {
        "seconds": round(record.seconds, 4),
        "processor": None if record.processor is None else round(record.processor, 4),
        "bytes": record.size,
        "warnings": [*record.warnings, *record.prepare_warnings],
        "inputs": {plug: short(found) for plug, found in record.parts["inputs"].items()},
        "outputs": {name: output.object for name, output in record.outputs.items()},
        "pictures": {name: found for name, found in pictures.items() if found},
    }


def short(found: Any) -> str:
    """Write the input of a socket in short: an object, two of them, or the number of frames."""
    if found is None:
        return "not connected"
    if isinstance(found, list):
        return f"{len(found)} frames" if isinstance(found[0], list) else " then ".join(map(short, found))
    return str(found)[:NAMED]


def verdict(shot: GraphShot, found: Plan, output: RunOutput, options: str = "") -> dict[str, Any]:
    """Summarise: frames, results cached, to compute and computed now, seconds, bytes, failures, versions."""
    records = found.records.values()
    return {
        "frames": fold_frames(frames_of(shot, found)),
        "cached": sum(entry.status == "cached" for entry in found),
        "missing": sum(entry.status != "cached" for entry in found),
        "hosts": Counter(output.hosts.values()),
        "seconds": sum(record.seconds for record in records),
        "processor": sum(record.processor or 0.0 for record in records),
        "bytes": sum(dict(pair for record in records for pair in record.objects()).values()),
        "failures": [],
        "versions": {"hairpipe": __version__, "python": platform.python_version()},
        "command": f"hairpipe run {shot.path.name}{options}",
    }


def frames_of(shot: GraphShot, found: Plan) -> set[int]:
    frames: dict[str, set[int]] = {}
    for entry in found:
        if entry.task.frame is not None:
            frames.setdefault(entry.task.node, set()).add(entry.task.frame)
    return set(shot.graph.all_frames).intersection(*frames.values()) if frames else set()


def machine_document(cache: Path) -> dict[str, int | None]:
    """Describe free memory, None where unknown, and free space on the disk of a cache [bytes]."""
    memory = None
    with suppress(OSError, ValueError):
        words = Path("/proc/meminfo").read_text().split()
        memory = 1024 * int(words[words.index("MemAvailable:") + 1])
    folder = next(folder for folder in (cache.absolute(), *cache.absolute().parents) if folder.exists())
    return {"memory": memory, "disk": shutil.disk_usage(folder).free}


def ending(run: Run) -> dict[str, Any]:
    """Describe the end of a run, for the verdict."""
    return {
        "failures": [str(failure) for failure in run.failures],
        "computed": run.outcome.evaluated,
        "reused": run.outcome.cached,
        "took": run.seconds,
        "interrupted": run.outcome.interrupted,
    }
