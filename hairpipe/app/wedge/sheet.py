"""Contact sheet of a wedge: the picture of every variant at a frame, with its settings."""

import math
from collections.abc import Mapping
from itertools import product
from pathlib import Path

from hairpipe.app.api.shot import File, Record, Task
from hairpipe.app.api.wedge_shot import Variant, WedgeShot
from hairpipe.engine.node.messages import nearest
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import write_below


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
    value = wedge.value(task, record)
    if not isinstance(value, File):
        raise BadInput(f"'{task}' is not a picture", where=wedge.path, right="show = a node whose output is a File")
    return value.path
