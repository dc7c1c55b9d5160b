"""What a run is told, and what it tells: options, events, outcome."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from hairpipe.graph.plan.tasks import Task

CODEC = "hairpipe.io.hdf5"

Kind = Literal["begun", "started", "finished", "cached", "failed", "warning", "published"]


@dataclass(frozen=True)
class Options:
    """How a run is carried out; none of it changes a result.

    jobs          number of processes for values per frame, and of threads for the one that simulates
    keep_going    whether independent branches go on after a failure
    codec         module that writes and reads values
    publish_root  folder below which files may be published beside the graph's project
    force         whether files are replaced that were not published by hairpipe
    """

    jobs: int = field(default_factory=lambda: os.cpu_count() or 1)
    keep_going: bool = False
    codec: str = CODEC
    publish_root: Path | None = None
    force: bool = False


@dataclass(frozen=True)
class Event:
    """Something that happened to a task.

    kind     begun: totals are known; started and finished: an evaluation; cached: its result was there; failed;
             warning: a node has something to say, also when its result was there; published: a file was written
    seconds  that the evaluation took, of `finished` and of `cached` [s]
    message  of a failure, a warning, or the path that was published
    totals   number of tasks by node, of `begun`
    """

    kind: Kind
    task: Task | None = None
    seconds: float = 0.0
    message: str = ""
    totals: tuple[tuple[str, int], ...] = ()

    def __str__(self) -> str:
        """One line: `hair@12: finished in 1.3 s`."""
        what = f"begun: {sum(count for _, count in self.totals):,} results" if self.kind == "begun" else self.kind
        took = f" in {self.seconds:.2g} s" if self.kind == "finished" else ""
        return f"{f'{self.task}: ' if self.task else ''}{what}{took}{f': {self.message}' if self.message else ''}"


Report = Callable[[Event], None]


@dataclass(frozen=True)
class Failure:
    """A task that did not give a result.

    kind       input: something a person can mend; node: it raised; diverged: it raised ArithmeticError itself, nothing
               derived from it; disk: full; crash: its process died; publish
    traceback  of the node, for those who wrote it
    """

    task: Task
    kind: Literal["input", "node", "diverged", "disk", "crash", "publish"]
    message: str
    traceback: str = ""

    def __str__(self) -> str:
        """One line: which node, which frame, what."""
        return f"{self.task}: {self.message}"


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    evaluated  number of evaluations; cached number of results that were there; blocked tasks that were not reached
    seconds    of evaluation by node, those of cached results not counted [s]
    processor  seconds of all threads in it, by node: what it takes beside waiting for others [s]
    """

    evaluated: int
    cached: int
    blocked: int
    failures: tuple[Failure, ...]
    published: tuple[str, ...]
    seconds: dict[str, float]
    processor: dict[str, float]
    interrupted: bool

    @property
    def exit_code(self) -> int:
        """0 all is there, 1 a node failed, 2 only for input that a person can mend, 130 interrupted."""
        if self.interrupted:
            return 130
        if not self.failures:
            return 0
        return 2 if all(failure.kind == "input" for failure in self.failures) else 1
