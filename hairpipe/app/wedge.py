"""Variants of a wedge in a table of settings, measures, seconds and bytes, and as pictures on a contact sheet."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from hairpipe.app.api.formatting import duration, size, table
from hairpipe.app.api.formatting import markdown as marked_down
from hairpipe.app.api.selection import FrameSet, read_frames
from hairpipe.app.api.shot import File, Record, Task, Variant, WedgeShot
from hairpipe.engine.node.messages import nearest
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import write_below

TIME = "time [s]"  # columns of measures that identify a row


@dataclass(frozen=True)
class Row:
    """A variant, as far as it has been computed.

    metrics  columns of the measures: a number or text, or the mean and the largest of several rows
    seconds  processor time of results that not all variants share [s]; results of several count for each of them
    """

    variant: str
    settings: dict[str, Any]  # different settings, by short names
    state: str  # empty for a complete variant; else why it was stopped, or how much is computed
    metrics: dict[str, float | str]
    seconds: float
    bytes: int  # size of the same results


def compare(wedge: WedgeShot, frames: FrameSet = None) -> list[Row]:
    """Compare the variants by cached results; nothing is computed.

    frames  frames of the run, all by default
    BadInput where a measured value is not a table.
    """
    records = wedge.results(frames)
    numbers = wedge.graph.select(read_frames(frames))
    comparison = Comparison(wedge, numbers, records)
    return [comparison.row(variant) for variant in wedge.variants.values()]


class Comparison:
    """Results of a wedge."""

    def __init__(self, wedge: WedgeShot, frames: Sequence[int], records: Mapping[str, Record]) -> None:
        self._wedge, self._frames, self._records = wedge, frames, records
        self._stopping = wedge.stopping()
        judged = {criterion.node for criterion in wedge.definition.stop}
        for task in {task: None for v in wedge.variants.values() for node in judged for task in self.tasks(v, node)}:
            if str(task) in records:
                self._stopping.limits(task, records[str(task)])

    def row(self, variant: Variant) -> Row:
        tasks = [task for node in variant.names for task in self.tasks(variant, node)]
        done = sum(str(task) in self._records for task in tasks)
        state = self._stopping.stopped().get(variant.name)
        state = f"stopped: {state}" if state else "" if done == len(tasks) else f"{done} of {len(tasks)} results"
        own = {task: self._records[str(task)] for task in tasks if str(task) in self._records and self.is_own(task)}
        records = {record.key: record for record in own.values()}.values()
        metrics = {n: value for node in self._wedge.definition.measures for n, value in self.metrics(variant, node)}
        names = self._wedge.definition.short_names
        settings = {names[target]: value for target, value in variant.settings.items()}
        seconds = sum(r.seconds if r.processor is None else r.processor for r in records)
        return Row(variant.name, settings, state, metrics, seconds, self._wedge.size_of(records))

    def is_own(self, task: Task) -> bool:
        """Whether a task is not common to all variants."""
        return any(task.node not in variant.names.values() for variant in self._wedge.variants.values())

    def tasks(self, variant: Variant, node: str) -> list[Task]:
        last = self._stopping.frame_of(variant.name)
        tasks = dict.fromkeys(self._wedge.task(variant, node, frame) for frame in self._frames)
        return [task for task in tasks if last is None or (task.frame is not None and task.frame <= last)]

    def metrics(self, variant: Variant, node: str) -> Iterator[tuple[str, float | str]]:
        """Summarise the columns of a measure, over all computed frames."""
        known = [task for task in self.tasks(variant, node) if str(task) in self._records]
        tables = [self._wedge.table(task, self._records[str(task)]) for task in known]
        label = f"{node}." if len(self._wedge.definition.measures) > 1 else ""
        for name in tables[0].names if tables else ():
            if name in tables[0].texts:
                yield f"{label}{name}", tables[-1].texts[name][-1] if len(tables[-1]) else ""
                continue
            values = np.concatenate([table.numbers[name] for table in tables]).astype(float)
            if len(values) == 1:
                yield f"{label}{name}", float(values[0])
            elif name != TIME and not np.isnan(values).all():
                yield f"{label}mean {name}", float(np.nanmean(values))
                yield f"{label}largest {name}", float(np.nanmax(values))


def document(wedge: WedgeShot, rows: Sequence[Row]) -> dict[str, Any]:
    """Describe the comparison as a JSON document, without values that are not finite."""
    described = [asdict(row) for row in rows]
    for row in described:
        row["metrics"] = {n: None if v in (np.inf, -np.inf) or v != v else v for n, v in row["metrics"].items()}
    return {"graph": str(wedge.path), "wedge": wedge.definition.name, "variants": described}


def cells(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    settings = list(rows[0].settings)
    metrics = list(dict.fromkeys(name for row in rows for name in row.metrics))
    head = (*settings, *metrics, "seconds", "size", "")
    body = [
        (
            *(shown(row.settings[name]) for name in settings),
            *(shown(row.metrics.get(name, "")) for name in metrics),
            duration(row.seconds),
            size(row.bytes),
            row.state,
        )
        for row in rows
    ]
    return [head, *body]


def text(rows: Sequence[Row]) -> str:
    """Write the comparison for a terminal, with one word per line in the head."""
    head, *body = cells(rows)
    words = [cell.split() for cell in head]
    deep = max(map(len, words))
    lines = [tuple(("", *[""] * (deep - len(cell)), *cell)[1 + line] for cell in words) for line in range(deep)]
    return table([*lines, *body], ">" * (len(head) - 1) + "<")


def markdown(rows: Sequence[Row]) -> str:
    """Write the comparison as a table of Markdown."""
    lines = cells(rows)
    return marked_down(lines, ">" * (len(lines[0]) - 1) + "<")


def shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return value if isinstance(value, str) else json.dumps(value, default=str)


def write_sheet(path: Path, wedge: WedgeShot, frame: int | None = None, node: str | None = None) -> None:
    """Write a PNG with a picture of every variant; where axes are crossed, each column is a value of the last of them.

    A variant without a picture has an empty place with a note.

    frame  frame of the pictures; None: the last of the shot
    node   node of the pictures; None: the first that the wedge shows
    BadInput for a wedge without pictures, or without computed ones.
    """
    shown = wedge.definition.show
    if not shown or (node is not None and node not in shown):
        what = "no picture is shown" if node is None else f"'{node}' is not shown"
        right = 'show = ["picture"]' if not shown or node is None else nearest(node, list(shown))
        raise BadInput(what, where=f"{wedge.path}: [wedge.{wedge.definition.name}]", right=right)
    node = node or shown[0]
    frame = wedge.frames[-1] if frame is None else frame
    places, columns = layout(wedge)
    records = wedge.results(frame if wedge.original.node(node).per_frame else None, to=node)
    pictures = [variant and picture_of(wedge, wedge.task(variant, node, frame), records) for variant in places]
    if not any(pictures):
        right = f"hairpipe run {wedge.path} --wedge {wedge.definition.name}"
        raise BadInput(f"no '{node}' has been computed at frame {frame}", where=wedge.path, right=right)
    words = {
        place: variant.name.replace(",", "\n") + ("" if picture else "\nno picture")
        for place, (variant, picture) in enumerate(zip(places, pictures, strict=True))
        if variant
    }
    files = {v.name if v else f"empty {place}": p for place, (v, p) in enumerate(zip(places, pictures, strict=True))}
    write_below(path, files, columns, words)


def layout(wedge: WedgeShot) -> tuple[list[Variant | None], int]:
    """Arrange the variants in rows; return them, None for an empty place, and the number of columns."""
    variants = list(wedge.variants.values())
    axes = wedge.definition.axes
    if wedge.definition.joint or len(axes) == 1:
        return list(variants), math.ceil(math.sqrt(len(variants)))
    rows = [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]
    found = [next((variant for variant in variants if variant.settings == row), None) for row in rows]
    return found, len(list(axes.values())[-1])


def picture_of(wedge: WedgeShot, task: Task, records: Mapping[str, Record]) -> Path | None:
    """Find a picture; None if it has not been computed, BadInput if its node has no pictures."""
    record = records.get(str(task))
    if record is None:
        return None
    value = wedge.read(task, record)
    if not isinstance(value, File):
        raise BadInput(f"'{task}' is not a picture", where=wedge.path, right="show = a node whose output is a File")
    return value.path
