"""Formats of a job: lines of commands, or a template of Open Job Description (2023-09), which farm managers take.

Paths are parameters without defaults there: whoever submits the job names them, and a farm maps them.
"""

import json
import shlex
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.farm.steps import Step

MOST_TASKS = 1024
"""Number of tasks that a step of Open Job Description may have."""
GRAPH, CACHE = "{{Param.Graph}}", "{{Param.Cache}}"
NAMES = {"--to": "Nodes", "--only": "Frames"}
"""Names of the parameters of tasks by option."""


def write_commands(steps: Iterable[Step], graph: str, cache: Path) -> str:
    """Write a command a line; those of a step can run at the same time, and steps begin with a comment."""
    lines = []
    for step in steps:
        lines.append(f"# {step.name}")
        for arguments in step.commands():
            lines.append(shlex.join(["hairpipe", "run", graph, "--cache", str(cache), *arguments]))
    return "\n".join(lines) + "\n"


def write_openjd(steps: Iterable[Step], graph: str, cache: Path) -> str:
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


FORMATS: dict[str, tuple[str, Callable[[Iterable[Step], str, Path], str]]] = {
    "openjd": ("job.json", write_openjd),
    "commands": ("commands.txt", write_commands),
}
"""Name of the file and its writer, by format."""
