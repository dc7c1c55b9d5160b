"""What is wrong in a stage, and the rules that find it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

Severity = Literal["error", "warning"]


class Fault(NamedTuple):
    """What a rule has found.

    path     of the layer, prim or attribute
    message  what is wrong, and what would be right
    time     code at which it was seen, or None where it does not depend on time
    """

    path: str
    message: str
    time: float | None = None


class Rule(NamedTuple):
    """A law that a stage keeps: an error breaks what is drawn, a warning breaks what others do with it."""

    name: str
    severity: Severity
    faults: Callable[..., Iterator[Fault]]


@dataclass(frozen=True)
class Finding:
    """A rule that is broken at one place.

    rule      its name
    path      of the layer, prim or attribute
    time      code at which it was first seen, or None
    message   what is wrong there, and what would be right
    severity  error or warning
    count     how often the rule is broken at this place
    """

    rule: str
    path: str
    time: float | None
    message: str
    severity: Severity
    count: int = 1

    def __str__(self) -> str:
        """Say it on one line."""
        time = "" if self.time is None else f" @ {self.time:g}"
        more = "" if self.count == 1 else f" [{self.count} times]"
        return f"{self.severity}: {self.rule}: {self.path}{time}: {self.message}{more}"
