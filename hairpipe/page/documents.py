"""A graph, and the state of its results, as documents for the browser."""

import platform
from collections.abc import Callable, Mapping
from typing import Any

from hairpipe import __version__
from hairpipe.api.node_types import document as type_document
from hairpipe.api.reports import Fate, Plan, Run, Task
from hairpipe.api.shot import Node, Record, Shot
from hairpipe.page.values import kinds_of

Suffix = Callable[[str], str | None]
"""Finds the suffix of a picture by the name of its object; None for any other file."""
RESERVED = ("type", "in", "publish", "checkpoint")
"""Keys in the table of a node that are no settings."""


def graph_document(shot: Shot) -> dict[str, Any]:
    """Describe a graph: its nodes in order, with sockets, wires, settings as set, and what each is."""
    tables = shot.tables
    return {
        "name": shot.path.stem,
        "file": shot.path.name,
        "frames": list(shot.graph.frames),
        "begin": shot.graph.begin,
        "fps": shot.fps,
        "nodes": [node_document(node, tables[node.name]) for node in shot.graph.nodes.values()],
        "types": {node.type.name: type_document(node.type) for node in shot.graph.nodes.values()},
    }


def node_document(node: Node, table: Mapping[str, Any]) -> dict[str, Any]:
    """Describe a node."""
    return {
        "name": node.name,
        "type": node.type.name,
        "doc": paragraphs(node.type.function.__doc__ or ""),
        "edges": [{"plug": plug, "node": edge.node, "output": edge.output} for plug, edge in node.edges.items()],
        "settings": node.settings,
        "given": {name: value for name, value in table.items() if name not in RESERVED},
        "publish": None if node.publish is None else node.publish.name,
        "per_frame": node.per_frame,
        "kinds": {name: kinds_of(kind) for name, kind in node.type.outputs.items()},
    }


def paragraphs(text: str) -> str:
    """Return the words of a docstring before its list of settings, which are shown one by one."""
    kept: list[str] = []
    for line in text.strip().splitlines():
        if "  " in line.strip():
            break
        kept.append(line.strip())
    return "\n".join(kept).strip()


def state_document(shot: Shot, found: Plan, suffix: Suffix, run: Run | None = None) -> dict[str, Any]:
    """Describe what is in the cache, what a run would do and why, or what one has done.

    found  plan of the shot
    run    that has ended, whose outcome is shown
    """
    fates: Mapping[Task, Fate] = run.fates if run else {}
    failures = {failure.task: failure.message for failure in run.outcome.failures} if run else {}
    nodes: dict[str, dict[str, Any]] = {name: {"cells": []} for name in shot.graph.nodes}
    for entry in found:
        state = fates.get(entry.task, "blocked" if run and entry.status == "depends" else entry.status)
        record = found.records.get(entry.task)
        cell: dict[str, Any] = {"frame": entry.task.frame, "state": state, "reason": entry.reason}
        if entry.task in failures:
            cell["reason"] = failures[entry.task]
        if record is not None:
            cell |= measured(record, suffix)
        nodes[entry.task.node]["cells"].append(cell)
    return {"nodes": nodes, "verdict": verdict(shot, found, run)}


def measured(record: Record, suffix: Suffix) -> dict[str, Any]:
    """Describe a result: seconds, of the processor too, bytes, warnings, the objects of its outputs."""
    pictures = {name: suffix(output.object) for name, output in record.outputs.items()}
    return {
        "seconds": round(record.seconds, 4),
        "processor": None if record.processor is None else round(record.processor, 4),
        "bytes": record.size,
        "warnings": [*record.warnings, *record.prepare_warnings],
        "outputs": {name: output.object for name, output in record.outputs.items()},
        "pictures": {name: found for name, found in pictures.items() if found},
    }


def verdict(shot: Shot, found: Plan, run: Run | None) -> dict[str, Any]:
    """Sum up: results in the cache and to compute, seconds, bytes, failures and warnings, versions, the command."""
    records = found.records.values()
    warnings = {(record.node, text) for record in records for text in (*record.warnings, *record.prepare_warnings)}
    document: dict[str, Any] = {
        "cached": sum(entry.status == "cached" for entry in found),
        "missing": sum(entry.status != "cached" for entry in found),
        "seconds": sum(record.seconds for record in records),
        "processor": sum(record.processor or 0.0 for record in records),
        "bytes": sum(dict(pair for record in records for pair in record.objects()).values()),
        "warnings": sorted(f"{node}: {text}" for node, text in warnings),
        "failures": [],
        "versions": {"hairpipe": __version__, "python": platform.python_version()},
        "command": f"hairpipe run {shot.path.name}",
    }
    if run is not None:
        document |= {
            "failures": [str(failure) for failure in run.outcome.failures],
            "computed": run.outcome.evaluated,
            "reused": run.outcome.cached,
            "took": run.seconds,
            "interrupted": run.outcome.interrupted,
        }
    return document
