"""Results of a run: values, and the processor time that they took."""

from collections.abc import Iterable
from typing import Any

from hairpipe.api.reports import Task
from hairpipe.api.shot import Shot


class Results:
    """The results of a shot, of a run at these frames, that are in the cache.

    What is not there is missing from them: nothing is computed.
    """

    def __init__(self, shot: Shot, frames: Iterable[int]) -> None:
        self._shot = shot
        self._records = shot.results(frames)

    def value(self, name: str) -> Any:
        """Read the value for the shot of a node; BadInput where it has not been computed."""
        return self._shot.read(Task(name, None), self._records.get(name))

    def seconds(self, name: str, frames: Iterable[int]) -> list[float]:
        """List the processor time of a node at frames or for the shot, each result once [s]; KeyError without one."""
        targets = (f"{name}@{frame}" for frame in frames) if self._shot.nodes[name].per_frame else (name,)
        records = [self._records[target] for target in targets]
        return list({r.key: r.seconds if r.processor is None else r.processor for r in records}.values())
