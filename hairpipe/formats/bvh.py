"""Biovision hierarchy files (.bvh): motion capture as text.

Alone among the formats of others they are read in this process: no library parses them that could crash, and to start
a child takes .2 to .3 s, where a clip of 60 kB takes .01 s. Memory and time are bounded by the size of the text,
`MOST_BYTES` of `text.py`, and of its hierarchy, MOST_LETTERS and MOST_JOINTS: the largest file takes 4 s and .9 GB.
"""

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.text import LARGEST, parse_number, parse_numbers, read_text
from hairpipe.plain_file import stamp_of
from hairpipe.values.body import Clip

CHANNELS = {
    name.lower(): name for name in ("Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation")
}
MOST_CHANNELS = 6  # of one joint
MOST_JOINTS = 10_000
MOST_LETTERS = 8 << 20
"""Maximum number of words of a HIERARCHY section: ten times that of any rig; a word takes 100 bytes of memory."""
END_SITE = -1


@dataclass
class Joint:
    """A joint of the file: `offset` and `end` [file units], `end` NaN without an End Site."""

    name: str
    parent: int
    offset: list[float] | None = None
    end: list[float] = field(default_factory=lambda: [np.nan] * 3)
    channels: list[str] = field(default_factory=list)


class Hierarchy:
    """Parser of the HIERARCHY section, without recursion, so that the depth is not limited.

    tokens  words and braces with their lines, each line ended by an empty word: names may contain blanks
    open    the joints whose braces are open, or END_SITE
    """

    def __init__(self, path: Path, lines: list[str]) -> None:
        self.path = path
        self.tokens = [
            token
            for number, line in enumerate(lines, start=1)
            for token in (*((word, number) for word in re.findall(r"[{}]|[^\s{}]+", line)), ("", number))
        ]
        self.place = 0
        self.joints: list[Joint] = []
        self.open: list[int] = []
        if self.word().upper() != "HIERARCHY":
            raise self.fault("the file does not begin with HIERARCHY", "a BVH file")
        for word in iter(self.word, ""):
            self.read_item(word)
        if self.open:
            raise self.fault("a brace is never closed", f"{len(self.open)} more }}")
        if not self.joints:
            raise self.fault("there is no joint", "ROOT and a name")

    def read_item(self, word: str) -> None:
        inner = self.open[-1] if self.open else None
        match word.upper():
            case "ROOT" | "JOINT" as keyword:
                self.begin_joint(keyword, inner)
            case "END":
                self.rest_of_line()
                if inner in (None, END_SITE):
                    raise self.fault("an End Site stands outside a joint", "End Site within a joint")
                self.begin(END_SITE)
            case "OFFSET":
                numbers = [self.number() for _ in range(3)]
                if inner is None:
                    raise self.fault("an OFFSET stands outside a joint", "OFFSET within a joint")
                if inner == END_SITE:
                    self.joints[self.open[-2]].end = numbers
                else:
                    self.joints[inner].offset = numbers
            case "CHANNELS":
                self.read_channels(inner)
            case "}" if inner is not None:
                self.open.pop()
                if inner != END_SITE and self.joints[inner].offset is None:
                    raise self.fault(f"joint {self.joints[inner].name!r} has no OFFSET", "OFFSET x y z")
            case _:
                right = "ROOT, JOINT, End Site, OFFSET, CHANNELS or a brace"
                raise self.fault(f"{word!r} is not understood here", right)

    def begin_joint(self, keyword: str, parent: int | None) -> None:
        if (keyword == "ROOT") != (parent is None):
            raise self.fault(f"a {keyword} stands in the wrong place", "ROOT outermost, JOINT within a joint")
        if parent == END_SITE:
            raise self.fault("a JOINT stands within an End Site", "JOINT within a joint")
        name = self.rest_of_line()
        if not name:
            raise self.fault(f"a {keyword} has no name", f"{keyword} Hips")
        if len(self.joints) == MOST_JOINTS:
            raise self.fault(f"there are more than {MOST_JOINTS:,} joints", "a skeleton")
        self.joints.append(Joint(name, -1 if parent is None else parent))
        self.begin(len(self.joints) - 1)

    def begin(self, joint: int) -> None:
        if self.word() != "{":
            raise self.fault("a brace is missing", "{ after the name")
        self.open.append(joint)

    def read_channels(self, joint: int | None) -> None:
        count = self.number()
        if joint is None or joint == END_SITE or self.joints[joint].channels:
            raise self.fault("CHANNELS stand in the wrong place", "once within a joint")
        if count not in range(MOST_CHANNELS + 1):
            raise self.fault(f"a joint cannot have {count:g} channels", f"0 to {MOST_CHANNELS}")
        names = [CHANNELS.get(self.word().lower(), "") for _ in range(int(count))]
        if "" in names:
            raise self.fault("a channel is missing or unknown", f"{int(count)} of {', '.join(CHANNELS.values())}")
        positions = [name for name in names if name.endswith("position")]
        if len(set(positions)) < len(positions):
            raise self.fault("a position channel stands twice in one joint", "each once")
        self.joints[joint].channels = names

    def word(self) -> str:
        """Return the next word, skipping line ends; empty at the end of the section."""
        while self.place < len(self.tokens):
            word, _ = self.tokens[self.place]
            self.place += 1
            if word:
                return word
        return ""

    def rest_of_line(self) -> str:
        words = []
        while self.place < len(self.tokens) and self.tokens[self.place][0] not in ("", "{", "}"):
            words.append(self.tokens[self.place][0])
            self.place += 1
        return " ".join(words)

    def number(self) -> float:
        word = self.word()
        value = parse_number(word)
        if value is None:
            raise self.fault(f"{word!r} is not a usable number", "a finite number")
        return value

    def fault(self, what: str, right: str) -> BadInput:
        """Return the fault at the latest word."""
        line = self.tokens[min(max(self.place - 1, 0), len(self.tokens) - 1)][1] if self.tokens else 1
        return BadInput(what, where=f"{self.path}, line {line}", right=right)


BLANKS = b" \t\v\f"


def recall_bvh(path: Path) -> Clip:
    """Read a clip once per process, as long as the file is unchanged; see `read_bvh`."""
    return _recall(path, stamp_of(str(path)))


@lru_cache(maxsize=8)
def _recall(path: Path, stamp: tuple[int, ...]) -> Clip:
    return read_bvh(path)


def read_bvh(path: Path) -> Clip:
    """Read a clip with any order of channels and any names of joints; BadInput with the line."""
    lines = read_text(path).splitlines()
    motion = next((i for i, line in enumerate(lines) if line.strip().upper() == "MOTION"), None)
    if motion is None:
        raise BadInput("there is no MOTION section", where=path, right="a BVH file: HIERARCHY, then MOTION")
    letters = sum(map(len, lines[:motion]))
    if letters > MOST_LETTERS:
        right = f"at most {MOST_LETTERS:,}, for at most {MOST_JOINTS:,} joints"
        raise BadInput(f"the HIERARCHY section has {letters:,} letters", where=path, right=right)
    hierarchy = Hierarchy(path, lines[:motion])
    frames, frame_time, first = _read_counts(path, lines, motion + 1)
    channels = tuple(tuple(joint.channels) for joint in hierarchy.joints)
    values = _read_values(path, lines, first, frames, sum(map(len, channels)))
    _put_in_place(hierarchy, values)
    return Clip(
        names=tuple(joint.name for joint in hierarchy.joints),
        parents=np.array([joint.parent for joint in hierarchy.joints], np.int32),
        offsets=np.array([joint.offset for joint in hierarchy.joints]),
        ends=np.array([joint.end for joint in hierarchy.joints]),
        channels=channels,
        values=values,
        frame_time=frame_time,
    )


def _read_counts(path: Path, lines: list[str], start: int) -> tuple[int, float, int]:
    """The number of frames, the frame time [s] and the index of the first line of values."""
    found = []
    patterns = (r"frames\s*:?\s*(\S+)", r"frame\s*time\s*:?\s*(\S+)")
    named = iter(zip(patterns, ("Frames: 120", "Frame Time: 0.00833333"), strict=True))
    for index, line in _filled(lines, start):
        if (expected := next(named, None)) is None:
            break
        match = re.fullmatch(expected[0], line.strip(), re.IGNORECASE)
        value = parse_number(match[1]) if match else None
        if value is None or value <= 0.0:
            what = f"{line.strip()[:60]!r} is not understood"
            raise BadInput(what, where=f"{path}, line {index + 1}", right=expected[1])
        found.append(value)
    else:
        index = len(lines)
    if len(found) < 2 or found[0] != int(found[0]):
        raise BadInput("the counts of the MOTION section are missing", where=path, right="Frames: and Frame Time:")
    return int(found[0]), found[1], index


def _filled(lines: list[str], start: int) -> Iterator[tuple[int, str]]:
    return ((index, lines[index]) for index in range(start, len(lines)) if lines[index].strip())


def _read_values(path: Path, lines: list[str], first: int, frames: int, width: int) -> np.ndarray:
    text = " ".join(lines[first:]).encode()
    is_blank = np.append(True, np.isin(np.frombuffer(text, np.uint8), np.frombuffer(BLANKS, np.uint8)))
    values = parse_numbers(text, np.count_nonzero(is_blank[:-1] & ~is_blank[1:]))
    if values is None or not (np.abs(values) <= LARGEST).all():
        raise _bad_word(path, lines, first)
    if len(values) > frames * width and len(values) % width == 0:
        extra = len(values) // width - frames
        message = f"{path}: the file has {frames + extra} frames, its header states {frames}: the last {extra}"
        warnings.warn(f"{message} {'is' if extra == 1 else 'are'} left out", stacklevel=2)
    elif len(values) != frames * width:
        raise _bad_count(path, lines, first, frames, width)
    return values[: frames * width].reshape(frames, width)


def _bad_word(path: Path, lines: list[str], first: int) -> BadInput:
    for index, line in _filled(lines, first):
        for word in line.split():
            if parse_number(word) is None:
                where = f"{path}, line {index + 1}"
                return BadInput(f"{word[:40]!r} is not a usable number", where=where, right="a finite number")
    return BadInput("the channel values cannot be read", where=path, right="finite numbers")


def _bad_count(path: Path, lines: list[str], first: int, frames: int, width: int) -> BadInput:
    counts = [(index, len(line.split())) for index, line in _filled(lines, first)]
    right = f"{frames} lines of {width} numbers, as Frames and CHANNELS say"
    for index, count in counts:
        if count != width:
            return BadInput(f"the line has {count} numbers", where=f"{path}, line {index + 1}", right=right)
    return BadInput(f"there are {len(counts)} frames", where=path, right=right)


def _put_in_place(hierarchy: Hierarchy, values: np.ndarray) -> None:
    """Replace the OFFSETs of all joints by their position channels, in place.

    Those of a root always do. Those of other joints do so in most files (Maya, MotionBuilder, Blender) but are added to
    it in some (MakeHuman), where they are nearer to 0 in the first two frames, of which one may be a T pose.
    """
    column = 0
    for joint in hierarchy.joints:
        places = [i for i, name in enumerate(joint.channels) if name.endswith("position")]
        columns = [column + i for i in places]
        offset = np.array(joint.offset)[["XYZ".index(joint.channels[i][0]) for i in places]]
        first = values[:2, columns]
        nearer = np.linalg.norm(first, axis=1) < np.linalg.norm(first - offset, axis=1)
        if joint.parent >= 0 and nearer.all():
            values[:, columns] += offset
        column += len(joint.channels)
