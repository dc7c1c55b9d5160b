"""HIERARCHY section of a Biovision file: nested joints."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.io.text import parse_number

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


def tokenise(lines: list[str]) -> list[tuple[str, int]]:
    """Words and braces with the number of their line, each line ended by an empty word: names may contain blanks."""
    words = []
    for number, line in enumerate(lines, start=1):
        words += [(word, number) for word in re.findall(r"[{}]|[^\s{}]+", line)]
        words.append(("", number))
    return words


class Hierarchy:
    """Parser of the HIERARCHY section, without recursion, so that the depth is not limited."""

    def __init__(self, path: Path, tokens: list[tuple[str, int]]) -> None:
        self.path = path
        self.tokens = tokens
        self.place = 0
        self.joints: list[Joint] = []
        self.open: list[int] = []  # the joints whose braces are open, or END_SITE

    def read(self) -> None:
        """Read the whole section."""
        if self.word().upper() != "HIERARCHY":
            raise self.fault("the file does not begin with HIERARCHY", "a BVH file")
        for word in iter(self.word, ""):
            self.read_item(word)
        if self.open:
            raise self.fault("a brace is never closed", f"{len(self.open)} more }}")
        if not self.joints:
            raise self.fault("there is no joint", "ROOT and a name")

    def read_item(self, word: str) -> None:
        """Read the item that begins with this word."""
        match word.upper():
            case "ROOT" | "JOINT":
                self.begin_joint(word.upper())
            case "END":
                self.rest_of_line()
                self.begin(END_SITE)
            case "OFFSET":
                self.read_offset()
            case "CHANNELS":
                self.read_channels()
            case "}" if self.open:
                self.end_block()
            case _:
                raise self.fault(
                    f"{word!r} is not understood here", "ROOT, JOINT, End Site, OFFSET, CHANNELS or a brace"
                )

    def begin_joint(self, keyword: str) -> None:
        """Read the name of a joint and its opening brace."""
        if (keyword == "ROOT") == bool(self.open):
            raise self.fault(f"a {keyword} stands in the wrong place", "ROOT outermost, JOINT within a joint")
        parent = self.open[-1] if self.open else -1
        if self.open and parent == END_SITE:
            raise self.fault("a JOINT stands within an End Site", "JOINT within a joint")
        name = self.rest_of_line()
        if not name:
            raise self.fault(f"a {keyword} has no name", f"{keyword} Hips")
        if len(self.joints) == MOST_JOINTS:
            raise self.fault(f"there are more than {MOST_JOINTS:,} joints", "a skeleton")
        self.joints.append(Joint(name, parent))
        self.begin(len(self.joints) - 1)

    def begin(self, joint: int) -> None:
        """Read the opening brace of a joint or an End Site."""
        if joint == END_SITE and (not self.open or self.open[-1] == END_SITE):
            raise self.fault("an End Site stands outside a joint", "End Site within a joint")
        if self.word() != "{":
            raise self.fault("a brace is missing", "{ after the name")
        self.open.append(joint)

    def end_block(self) -> None:
        """Close the innermost brace."""
        joint = self.open.pop()
        if joint != END_SITE and self.joints[joint].offset is None:
            raise self.fault(f"joint {self.joints[joint].name!r} has no OFFSET", "OFFSET x y z")

    def read_offset(self) -> None:
        """Read the offset of a joint or of its end."""
        numbers = [self.number() for _ in range(3)]
        if not self.open:
            raise self.fault("an OFFSET stands outside a joint", "OFFSET within a joint")
        if self.open[-1] == END_SITE:
            self.joints[self.open[-2]].end = numbers
        else:
            self.joints[self.open[-1]].offset = numbers

    def read_channels(self) -> None:
        """Read the channels of a joint."""
        count = self.number()
        if not self.open or self.open[-1] == END_SITE or self.joints[self.open[-1]].channels:
            raise self.fault("CHANNELS stand in the wrong place", "once within a joint")
        if count not in range(MOST_CHANNELS + 1):
            raise self.fault(f"a joint cannot have {count:g} channels", f"0 to {MOST_CHANNELS}")
        names = [CHANNELS.get(self.word().lower(), "") for _ in range(int(count))]
        if "" in names:
            raise self.fault("a channel is missing or unknown", f"{int(count)} of {', '.join(CHANNELS.values())}")
        positions = [name for name in names if name.endswith("position")]
        if len(set(positions)) < len(positions):
            raise self.fault("a position channel stands twice in one joint", "each once")
        self.joints[self.open[-1]].channels = names

    def word(self) -> str:
        """The next word, skipping line ends; empty at the end of the section."""
        while self.place < len(self.tokens):
            word, _ = self.tokens[self.place]
            self.place += 1
            if word:
                return word
        return ""

    def rest_of_line(self) -> str:
        """The words up to the end of the line or a brace, as one name."""
        words = []
        while self.place < len(self.tokens) and self.tokens[self.place][0] not in ("", "{", "}"):
            words.append(self.tokens[self.place][0])
            self.place += 1
        return " ".join(words)

    def number(self) -> float:
        """The next word as a number."""
        word = self.word()
        value = parse_number(word)
        if value is None:
            raise self.fault(f"{word!r} is not a usable number", "a finite number")
        return value

    def fault(self, what: str, right: str) -> BadInput:
        """Make the message for a fault at the latest word."""
        line = self.tokens[min(max(self.place - 1, 0), len(self.tokens) - 1)][1] if self.tokens else 1
        return BadInput(what, where=f"{self.path}, line {line}", right=right)
