"""Steps of a shot for a farm: commands that compute it in parts.

Their order saves time and changes no result: a command computes whatever it needs that is not in the store.

Formats of a job: lines of commands, or a template of Open Job Description (2023-09), which farm managers take.

Paths are parameters without defaults there: whoever submits the job names them, and a farm maps them.
"""

import json
import shlex
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, product
from math import prod
from pathlib import Path
from typing import Any

from hairpipe.app.api.reports import Level
from hairpipe.app.api.selection import fold_frames
from hairpipe.errors import BadInput

WAIT = 600  # time for which a command waits for what another one computes [s]


@dataclass(frozen=True)
class JobStep:
    """Commands that can run at the same time."""

    name: str
    arguments: tuple[str, ...]
    parts: dict[str, tuple[str, ...]]

    def __len__(self) -> int:
        return prod(map(len, self.parts.values()))

    def commands(self) -> Iterator[tuple[str, ...]]:
        for values in product(*self.parts.values()):
            yield (*self.arguments, *chain.from_iterable(zip(self.parts, values, strict=True)))


def build_steps(levels: Sequence[Level], frames: Sequence[int], chunk: int, common: Sequence[str]) -> list[JobStep]:
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
        steps.append(JobStep(level.name, (*shared, *named), parts))
    return steps


MOST_TASKS = 1024  # number of tasks that a step of Open Job Description may have
GRAPH, CACHE = "{{Param.Graph}}", "{{Param.Cache}}"
NAMES = {"--to": "Nodes", "--only": "Frames"}  # names of the parameters of tasks by option


def write_commands(steps: Iterable[JobStep], graph: str, cache: Path) -> str:
    """Write a command a line; those of a step can run at the same time, and steps begin with a comment."""
    lines = []
    for step in steps:
        lines.append(f"# {step.name}")
        for arguments in step.commands():
            lines.append(shlex.join(["hairpipe", "run", graph, "--cache", str(cache), *arguments]))
    return "\n".join(lines) + "\n"


def write_openjd(steps: Iterable[JobStep], graph: str, cache: Path) -> str:
    """Write a job template as JSON; BadInput for a step of too many tasks."""
    before = None
    written = []
    for step in steps:
        if len(step) > MOST_TASKS:
            right = f"at most {MOST_TASKS}: a larger --chunk, or fewer variants"
            raise BadInput(f"{len(step)} tasks in '{step.name}'", right=right)
        part = [word for option in step.parts for word in (option, f"{{{{Task.Param.{NAMES[option]}}}}}")]
        arguments = ["run", GRAPH, "--cache", CACHE, *step.arguments, *part]
        entry: dict[str, Any] = {"name": step.name}
        if before is not None:
            entry["dependencies"] = [{"dependsOn": before}]
        if step.parts:  # of several parameters, a task for each combination
            defined = [
                {"name": NAMES[option], "type": "STRING", "range": list(of)} for option, of in step.parts.items()
            ]
            entry["parameterSpace"] = {"taskParameterDefinitions": defined}
        entry["script"] = {"actions": {"onRun": {"command": "hairpipe", "args": arguments}}}
        written.append(entry)
        before = step.name
    file = {"name": "Graph", "type": "PATH", "objectType": "FILE", "dataFlow": "IN", "description": graph}
    folder = {"name": "Cache", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT"}
    template = {
        "specificationVersion": "jobtemplate-2023-09",
        "name": Path(graph).stem,
        "parameterDefinitions": [file, folder],
        "steps": written,
    }
    return json.dumps(template, indent=2) + "\n"


FORMATS: dict[str, tuple[str, Callable[[Iterable[JobStep], str, Path], str]]] = {
    "openjd": ("job.json", write_openjd),
    "commands": ("commands.txt", write_commands),
}
"""Name of the file and its writer, by format."""
