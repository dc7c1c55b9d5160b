"""Selection of results: targets such as `hair.strands@1020`, sets of frames, names of nodes."""

import re
from collections.abc import Iterable
from typing import NamedTuple

from hairpipe.engine.file.read import fold_frames, parse_frames
from hairpipe.errors import BadInput

__all__ = ["FrameSet", "Names", "Target", "fold_frames", "read_frames", "read_names", "read_target"]

FrameSet = str | int | Iterable[int] | None
"""A text such as `1001-1060x2`, a frame, several frames, or None for all frames of the graph."""
Names = str | Iterable[str]
"""Name of a node, or several."""


class Target(NamedTuple):
    """A result: node, output (None for the first), frame (None for a value for the shot)."""

    node: str
    output: str | None
    frame: int | None


def read_target(text: str) -> Target:
    """Read `NODE[.OUTPUT][@FRAME]`; BadInput for another text."""
    match = re.fullmatch(r"([^.@]+)(?:\.([^.@]+))?(?:@(-?\d{1,9}))?", text)
    if not match:
        raise BadInput(
            f"'{text}' is not the name of a result", right="NODE@FRAME, NODE.OUTPUT@FRAME, or NODE for the shot"
        )
    return Target(match[1], match[2], int(match[3]) if match[3] else None)


def read_frames(given: FrameSet) -> tuple[int, ...] | None:
    """Read a set of frames, in ascending order; None for all of them. BadInput for any other text."""
    if given is None:
        return None
    if isinstance(given, str):
        return parse_frames(given)
    return (given,) if isinstance(given, int) else tuple(sorted({int(frame) for frame in given}))


def read_names(given: Names) -> list[str]:
    """List names of nodes."""
    return [given] if isinstance(given, str) else list(given)
