"""Says how far a list of scenes is, and how long the rest will take."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import monotonic

from hairpipe.app.api.formatting import duration
from hairpipe.app.api.reports import Outcome
from hairpipe.app.api.shot import Shot
from hairpipe.app.tune.study import RunNodes


class Pace:
    """How fast scenes are done, judged by those of which something was computed: others are known at once.

    total   scenes
    runner  makes what carries out the runs of one; `run` does so, and takes notice
    clock   in seconds
    """

    def __init__(
        self,
        total: int,
        runner: Callable[[], RunNodes],
        echo: Callable[[str], None],
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._total, self._runner, self._say, self._clock = total, runner, echo, clock
        self._run = runner()
        self._done = 0
        self._computed = False
        self._spent: list[float] = []

    def run(self, text: str, shot: Shot, nodes: Sequence[str], frames: Sequence[int], *, timed: bool = True) -> Outcome:
        """Run a run."""
        outcome = self._run(text, shot, nodes, frames, timed=timed)
        self._computed |= outcome.evaluated > 0
        return outcome

    @contextmanager
    def scene(self, text: str) -> Iterator[None]:
        """Say that a scene begins, and how long it and those after it should take."""
        begun, self._run, self._computed = self._clock(), self._runner(), False
        self._say(f"{self._done + 1} of {self._total}: {text}{self._rest()}")
        yield
        self._done += 1
        if self._computed:
            self._spent.append(self._clock() - begun)

    def _rest(self) -> str:
        if not self._spent:
            return ""
        each = sum(self._spent) / len(self._spent)
        return f"; {duration(each)} each, {duration(each * (self._total - self._done))} left"
