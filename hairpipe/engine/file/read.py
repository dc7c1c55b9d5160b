"""Reads the text of a graph file: TOML to tables, and line numbers for messages.

Frame sets as text: `1-100x2,150`.
"""

import os
import re
import stat
import tomllib
from collections.abc import Iterable, Sequence
from copy import copy
from functools import cached_property
from pathlib import Path
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain

MOST_BYTES = 1 << 20
MOST_NAMES = 16
"""Maximum number of names in a dotted key: the memory of `tomllib` is quadratic in it."""
NAME = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*"|'[^'\n]*')"""
DOTTED = re.compile(rf"(?:{NAME}[ \t]*+\.[ \t]*+){{{MOST_NAMES}}}")
LINE = re.compile(r"\(at line (\d+), ")
ESCAPE = """a backslash in "..." is an escape: write / or '...'"""
HEADER = re.compile(r"""\s*\[\s*(?:(wedge\.[\w-]+|[\w-]+)|["']([^"']*)["'])\s*[\].]""")
"""Header of a table; that of a wedge has two names."""


class Location(str):
    """Place in a graph file, as messages show it, with the names at that place.

    node   name of the node; None for the head of the file
    names  names from the node to a setting; none for the node itself
    """

    node: str | None
    names: tuple[str, ...]

    def __new__(cls, shown: str, node: str | None = None, names: Sequence[str] = ()) -> "Location":
        location = super().__new__(cls, shown)
        location.node = node
        location.names = tuple(names)
        return location


class GraphText:
    """A graph file: its text, its tables, and their lines."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self.text = text
        self._lines = text.splitlines()
        long = DOTTED.search(text)
        if long:
            line = text.count("\n", 0, long.start()) + 1
            raise BadInput(f"a key of more than {MOST_NAMES} names", where=f"{path}:{line}", right="node.group.setting")
        try:
            self.tables: dict[str, Any] = tomllib.loads(text.replace("\r\n", "\n"))
        except (ValueError, RecursionError) as error:
            what = "nested too deeply" if isinstance(error, RecursionError) else str(error)
            place = LINE.search(what)
            escaped = place is not None and "\\" in self._lines[int(place[1]) - 1]
            raise BadInput(f"not valid TOML: {what}", where=path, right=ESCAPE if escaped else None) from None

    def edited(self, tables: dict[str, Any]) -> "GraphText":
        """Return the same text with other tables; names that are absent from the text have no line."""
        other = copy(self)
        other.tables = tables
        return other

    def place(self, node: str | None = None, names: Sequence[str] = (), node_type: str = "") -> Location:
        """Return the place of a node, or of a name within it, as `graph.toml:12: [hair]`; the line may be unknown.

        node_type  type of the node, to show
        """
        line = self._line(node, names)
        label = f": [{node}] {node_type}".rstrip() if node is not None else ""
        return Location(f"{self.path}:{line}{label}" if line else f"{self.path}{label}", node, names)

    def _line(self, node: str | None, names: Sequence[str]) -> int | None:
        """Find the line of the innermost name in the text, else the first line of the node."""
        own = self._owned.get(node, [])
        for name in reversed(names):
            word = re.compile(rf"(?<!\w){re.escape(name)}(?!\w)")
            found = next((n for n in own if word.search(self._lines[n].partition("#")[0])), None)
            if found is not None:
                return found + 1
        return own[0] + 1 if own and node is not None else None

    @cached_property
    def _owned(self) -> dict[str | None, list[int]]:
        """Numbers of the lines by top-level table; None: before the first."""
        owned: dict[str | None, list[int]] = {}
        owner = None
        for number, line in enumerate(self._lines):
            header = HEADER.match(line)
            owner = header[1] or header[2] if header else owner
            owned.setdefault(owner, []).append(number)
        return owned


def read_graph_text(path: Path) -> GraphText:
    """Read a graph file; BadInput if it is unreadable, too large, not UTF-8 or not TOML."""
    try:
        check_plain(path, "a graph file, such as demo.toml")
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    except FileNotFoundError:
        raise BadInput("no such file", where=path, right="a graph file, such as demo.toml") from None
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot be read: {getattr(error, 'strerror', None) or error}", where=path) from None
    status = os.fstat(handle)
    if not stat.S_ISREG(status.st_mode):
        os.close(handle)
        raise BadInput("not a file", where=path, right="a graph file, such as demo.toml")
    with os.fdopen(handle, "rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise BadInput(f"{status.st_size} bytes are too many for a graph", where=path, right=f"<= {MOST_BYTES}")
    try:
        return GraphText(path, data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise BadInput("not UTF-8", where=f"{path}:{line}", right="a text file encoded as UTF-8") from None


MOST_FRAMES = 1_000_000
PART = re.compile(r"(-?\d{1,9})(?:-(-?\d{1,9})(?:x(\d{1,9}))?)?")


def parse_frames(text: str) -> tuple[int, ...]:
    """Read `first-last`, `first-lastxstep` and single frames, separated by commas; ascending, without duplicates."""
    numbers: set[int] = set()
    for part in text.split(","):
        match = PART.fullmatch(part.strip())
        if not match:
            raise BadInput(f"'{text}' is not a valid frame set", right="frames and ranges such as 1-100x2,150")
        first = int(match[1])
        last = int(match[2] or match[1])
        step = int(match[3] or 1)
        if last < first or step < 1:
            raise BadInput(f"'{part}' is an empty range", right="first-last with first <= last, step >= 1")
        if (last - first) // step + len(numbers) >= MOST_FRAMES:
            raise BadInput(f"'{part}' is too long", right=f"at most {MOST_FRAMES} frames")
        numbers.update(range(first, last + 1, step))
    return tuple(sorted(numbers))


def fold_frames(frames: Iterable[int]) -> str:
    """Write frames as ranges: the inverse of `parse_frames`."""
    numbers = sorted(set(frames))
    parts = []
    start = 0
    while start < len(numbers):
        step = numbers[start + 1] - numbers[start] if start + 1 < len(numbers) else 1
        end = start
        while end + 1 < len(numbers) and numbers[end + 1] - numbers[end] == step:
            end += 1
        if step > 1 and end == start + 1:  # a run of two has step 1
            end = start
        run = f"{numbers[start]}-{numbers[end]}" + (f"x{step}" if step > 1 else "")
        parts.append(run if end > start else str(numbers[start]))
        start = end + 1
    return ",".join(parts)
