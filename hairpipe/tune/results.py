"""Results of a run: values, and their processor time."""

from collections.abc import Iterable
from typing import Any

from hairpipe.api.reports import Task
from hairpipe.api.shot import Record, Shot


class Results:
    """Cached results of a shot, of a run at these frames.

    Nothing is computed; a result that is not in the cache is missing.
    """

    def __init__(self, shot: Shot, frames: Iterable[int]) -> None:
        self._shot = shot
        self._records = shot.results(frames)

    def value(self, name: str) -> Any:
        """Read the value for the shot of a node; BadInput where it has not been computed."""
        return self._shot.read(Task(name, None), self._records.get(name))

    @property
    def processor(self) -> dict[str, float]:
        """Processor time of all results, by key [s]."""
        return {record.key: time_of(record) for record in self._records.values()}

    def seconds(self, name: str, frames: Iterable[int]) -> list[float]:
        """List the processor time of a node at frames or for the shot, each result once [s]; KeyError without one."""
        targets = (f"{name}@{frame}" for frame in frames) if self._shot.nodes[name].per_frame else (name,)
        records = [self._records[target] for target in targets]
        return list({record.key: time_of(record) for record in records}.values())


def time_of(record: Record) -> float:
    """Return the processor time of a result, or its duration where that is not known [s]."""
    return record.seconds if record.processor is None else record.processor
