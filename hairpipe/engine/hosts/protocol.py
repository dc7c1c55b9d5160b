"""The protocol between a scheduler and an engine, which evaluates jobs on this machine or on others."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from hairpipe.engine.store.digest import Parts

Reply = dict[str, Any]
"""Answer to a job, as plain values: its `key`, the `machine`, `held`, the objects that only its worker has, and one of

record   fields of its record, which is in the store; with `found`, it was there before
leased   another process evaluates it, or has the state that it starts from in memory
lost     name of an object that is missing
failure  kind, message and traceback, as in `Failure`
"""


@dataclass(frozen=True)
class Job:
    """An evaluation, as plain values: its JSON may go to another machine.

    module   of the node type, by which a host digests its code
    parts    of the key; inputs are named by their digests
    settings of the node, with absolute paths of files
    files    digests of those files by path
    outputs  names of the outputs
    spared   output that a stored result may lack: the state of a scan, which may have been thinned
    wide     whether it runs on all threads of a machine
    avoid    machines that have failed at it
    fleeting output that may stay in memory, unwritten: the state of a scan that only its next frame takes
    """

    key: str
    node: str
    frame: int | None
    type: str
    module: str
    parts: Parts
    settings: dict[str, Any]
    time: dict[str, Any]
    files: dict[str, str]
    outputs: tuple[str, ...]
    spared: str | None
    wide: bool
    avoid: tuple[str, ...] = ()
    fleeting: str | None = None


class Slots(NamedTuple):
    """Numbers of jobs that can begin now: wide ones take all threads of a machine, narrow ones run next to others."""

    wide: int
    narrow: int


class Engine(Protocol):
    """Evaluates jobs; at most as many at a time as there are slots.

    machines  names of those that take jobs
    """

    machines: set[str]

    @property
    def warnings(self) -> list[str]:
        """Warnings for the user."""
        ...

    def slots(self) -> Slots:
        """Count the free slots."""
        ...

    def submit(self, job: Job) -> None:
        """Begin a job in a free slot."""
        ...

    def replies(self, timeout: float | None) -> Iterator[Reply]:
        """Wait for replies, at most for a time [s]; a machine or process that is gone gives a failure."""
        ...

    def leave_out(self, machine: str) -> None:
        """Give a machine no further jobs."""
        ...

    def cancel(self, keys: Iterable[str]) -> None:
        """Stop jobs, which are not replied to."""
        ...

    def close(self) -> None:
        """End the use of all machines; jobs have been replied to or cancelled."""
        ...
