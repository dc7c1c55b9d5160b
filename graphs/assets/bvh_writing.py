"""Biovision files written: our own clips are made by code and kept as files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hairpipe.values.body import Clip


def write_bvh(path: Path, clip: Clip) -> None:
    """Write a clip, channels to six decimal places; joints come depth first, whatever their order in the clip."""
    lines = ["HIERARCHY"]
    order = []
    children = [np.flatnonzero(clip.parents == joint) for joint in range(len(clip.names))]
    stack: list[int | str] = list(np.flatnonzero(clip.parents < 0)[::-1])
    depth = 0
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            depth -= 1
            lines.append("\t" * depth + item)
            continue
        order.append(item)
        lines += ["\t" * depth + line for line in _joint_lines(clip, item)]
        depth += 1
        stack += ["}", *children[item][::-1]]
    lines += ["MOTION", f"Frames: {len(clip.values)}", f"Frame Time: {clip.frame_time:.9g}"]
    lines += [" ".join(f"{value:.9g}" for value in row) for row in np.round(_values_of(clip, order), 6) + 0.0]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _joint_lines(clip: Clip, joint: int) -> list[str]:
    keyword = "ROOT" if clip.parents[joint] < 0 else "JOINT"
    lines = [f"{keyword} {clip.names[joint]}", "{", _offset_line(clip.offsets[joint])]
    lines.append("\t" + " ".join(["CHANNELS", str(len(clip.channels[joint])), *clip.channels[joint]]))
    if np.isfinite(clip.ends[joint]).all():
        lines += ["\tEnd Site", "\t{", "\t" + _offset_line(clip.ends[joint]), "\t}"]
    return lines


def _values_of(clip: Clip, order: Sequence[int]) -> np.ndarray:
    """Return the values of all channels, (F, C), joint after joint in an order."""
    counts = [len(channels) for channels in clip.channels]
    columns = np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1])
    return clip.values[:, np.concatenate([columns[joint] for joint in order])]


def _offset_line(offset: np.ndarray) -> str:
    return "\tOFFSET " + " ".join(f"{value:.9g}" for value in offset)
