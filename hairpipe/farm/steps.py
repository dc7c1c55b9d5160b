"""Steps of a shot for a farm: commands that compute it in parts.

Their order saves time and changes no result: a command computes whatever it needs that is not in the store.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, product
from math import prod

from hairpipe.api.reports import Level
from hairpipe.api.selection import fold_frames

WAIT = 600
"""Time for which a command waits for what another one computes [s]."""


@dataclass(frozen=True)
class Step:
    """Commands that can run at the same time.

    arguments  of all of them, after `hairpipe run GRAPH`
    parts      values of options by option: a command for each combination; empty for a single command
    """

    name: str
    arguments: tuple[str, ...]
    parts: dict[str, tuple[str, ...]]

    def __len__(self) -> int:
        """Return the number of commands."""
        return prod(map(len, self.parts.values()))

    def commands(self) -> Iterator[tuple[str, ...]]:
        """Iterate over the arguments of each command."""
        for values in product(*self.parts.values()):
            yield (*self.arguments, *chain.from_iterable(zip(self.parts, values, strict=True)))


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
        groups = level.groups
        parts = {"--to": tuple(map(" ".join, groups))} if len(groups) > 1 else {}
        parts |= {"--only": chunks} if level.by_frame else {}
        named = [word for name in groups[0] for word in ("--to", name)] if len(groups) == 1 else []
        steps.append(Step(level.name, (*shared, *named), parts))
    return steps
