"""Steps of a shot for a farm: commands that compute it in parts.

Their order saves time and changes no result: a command computes whatever it needs that is not in the store.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from hairpipe.api.reports import Level
from hairpipe.api.selection import fold_frames

WAIT = 600
"""Time for which a command waits for what another one computes [s]."""


@dataclass(frozen=True)
class Step:
    """Commands that can run at the same time.

    arguments  of all of them, after `hairpipe run GRAPH`
    option     that takes the part of each; empty for a single command
    parts      values of that option
    """

    name: str
    arguments: tuple[str, ...]
    option: str = ""
    parts: tuple[str, ...] = ()

    def commands(self) -> Iterator[tuple[str, ...]]:
        """Iterate over the arguments of each command."""
        yield from ([(*self.arguments, self.option, part) for part in self.parts] if self.option else [self.arguments])


def build_steps(levels: Sequence[Level], frames: Sequence[int], chunk: int, common: Sequence[str]) -> list[Step]:
    """Build a step for each level of a shot.

    frames  of the shot, ascending
    chunk   number of frames of a command
    common  arguments of all commands: settings, wedge
    """
    shared = (*common, "--frames", fold_frames(frames), "--wait", str(WAIT))
    chunks = tuple(fold_frames(frames[start : start + chunk]) for start in range(0, len(frames), chunk))
    steps = []
    for level in levels:
        named = tuple(word for name in level.nodes for word in ("--to", name))
        if level.divided == "nodes":
            steps.append(Step(level.name, shared, "--to", level.nodes))
        elif level.divided == "frames":
            steps.append(Step(level.name, (*shared, *named), "--only", chunks))
        else:
            steps.append(Step(level.name, (*shared, *named)))
    return steps
