"""Divides the text of a graph file into statements: headers, values of one or more lines, comments, blank lines."""

import re
import tomllib
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from hairpipe.errors import BadInput
from hairpipe.graph.file.read import NAME

KEY = re.compile(rf"[ \t]*({NAME}(?:[ \t]*\.[ \t]*{NAME})*)[ \t]*=")
HEADER = re.compile(rf"[ \t]*\[\[?[ \t]*({NAME}(?:[ \t]*\.[ \t]*{NAME})*)[ \t]*\]")
PART = re.compile(NAME)
LONGEST = 200
"""Maximum number of lines of one value."""

Names = tuple[str, ...]


class Statement(NamedTuple):
    """Lines of a graph file that belong together.

    kind    "header", "value", "comment" or "blank"
    text    with the end of the last line
    path    names from the root to a table or value; of a comment or blank line those of the table around it
    header  path of the table in which it is
    """

    kind: str
    text: str
    path: Names
    header: Names

    @property
    def key(self) -> Names:
        """Names of a value, below those of its table."""
        return self.path[len(self.header) :]

    def renamed(self, depth: int, name: str) -> "Statement":
        """Return a header or value with another name in its path, or unchanged if the table around it has the name."""
        path = (*self.path[:depth], name, *self.path[depth + 1 :])
        above = len(self.header) if self.kind == "value" else 0
        header = path[: len(self.header)]
        if depth < above:
            return self._replace(path=path, header=header)
        found = (KEY if self.kind == "value" else HEADER).match(self.text)
        assert found is not None
        part = list(PART.finditer(self.text, found.start(1), found.end(1)))[depth - above]
        text = self.text[: part.start()] + name + self.text[part.end() :]
        return self._replace(path=path, header=header, text=text)


def read_statements(text: str) -> list[Statement]:
    """Divide a text; BadInput for one that is not TOML. The texts of all statements together are the text."""
    lines = re.findall(r"[^\n]*\n|[^\n]+\Z", text)
    found: list[Statement] = []
    header: Names = ()
    place = 0
    while place < len(lines):
        line = lines[place]
        bare = line.strip()
        place += 1
        if not bare or bare.startswith("#"):
            found.append(Statement("comment" if bare else "blank", line, header, header))
        elif match := HEADER.match(line):
            header = names_in(match[1])
            found.append(Statement("header", line, header, header))
        else:
            while not is_complete(line):
                if place == len(lines) or line.count("\n") > LONGEST:
                    raise BadInput("not a value of TOML", where=bare[:80])
                line += lines[place]
                place += 1
            key = KEY.match(line)
            assert key is not None
            found.append(Statement("value", line, (*header, *names_in(key[1])), header))
    return found


def text_of(statements: Sequence[Statement]) -> str:
    """Join statements."""
    return "".join(statement.text for statement in statements)


def names_in(dotted: str) -> Names:
    """Read the names of a dotted key."""
    return tuple(part[0].strip("\"'") for part in PART.finditer(dotted))


@lru_cache(4096)
def is_complete(text: str) -> bool:
    """Whether lines are TOML, and not the beginning of a value of more lines."""
    try:
        tomllib.loads(text.replace("\r\n", "\n"))
    except (ValueError, RecursionError):
        return False
    return True


def owners(statements: Sequence[Statement]) -> list[str | None]:
    """Return the first name of the table to which each statement belongs; None for the head of the file.

    Comments directly above a header belong to the table below.
    """
    found = [statement.path[0] if statement.path else None for statement in statements]
    attached: str | None = None
    for place in range(len(statements) - 1, -1, -1):
        kind = statements[place].kind
        attached = found[place] if kind == "header" else attached if kind == "comment" else None
        if attached is not None:
            found[place] = attached
    return found
