"""Faults of a stage, and the rules that find them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

Severity = Literal["error", "warning"]
Subject = Literal["stage", "asset", "prim", "field", "curves", "shape", "frame", "scene", "hair"]
"""Arguments of a rule: the stage, a file that it names, a prim, a field of a volume and a reader of its file, curves or
any shape at one time, hair with its motion at one time, all visible shapes, or these and one hair over time."""


class Fault(NamedTuple):
    """A fault found by a rule.

    path     of the layer, prim or attribute
    message  fault and remedy
    time     time code, or None where the fault does not depend on time
    """

    path: str
    message: str
    time: float | None = None


def fault_of(item: Any, message: str, time: float | None = None) -> Fault:
    """Return a fault of a prim or property."""
    return Fault(str(item.GetPath()), message, time)


class Rule(NamedTuple):
    """A rule for stages: an error breaks the picture, a warning breaks the use in other programs."""

    name: str
    severity: Severity
    subject: Subject
    faults: Callable[..., Iterator[Fault]]


@dataclass(frozen=True)
class Finding:
    """A rule that is broken at one place, by its name; `time` is the first time code, `count` the number of faults."""

    rule: str
    path: str
    time: float | None
    message: str
    severity: Severity
    count: int = 1

    def __str__(self) -> str:
        time = "" if self.time is None else f" @ {self.time:g}"
        more = "" if self.count == 1 else f" [{self.count} times]"
        return f"{self.severity}: {self.rule}: {self.path}{time}: {self.message}{more}"
