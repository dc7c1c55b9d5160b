"""Reports of plans, runs and single results: objects whose text is a table."""
# pyright: reportGeneralTypeIssues=false

import json
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Protocol

from hairpipe.app.api.formatting import duration, plural, shown, size, table
from hairpipe.app.api.selection import FrameSet
from hairpipe.engine.file.graph import Graph, origin
from hairpipe.engine.file.read import Location, fold_frames
from hairpipe.engine.node.messages import one_line
from hairpipe.engine.plan import planner
from hairpipe.engine.plan.planner import Entry
from hairpipe.engine.plan.tasks import Level, Task
from hairpipe.engine.run.events import Event, Failure, NodeProgress, Outcome, Progress
from hairpipe.engine.run.survey import NodeSurvey, Survey
from hairpipe.engine.store.store import Record
from hairpipe.errors import BadInput

__all__ = ["Entry", "Event", "Explanation", "Failure", "Graph", "Level", "NodeProgress", "NodeSurvey", "Outcome"]
__all__ += ["Plan", "Progress", "Recorder", "Run", "Survey", "Task", "origin"]


Status = Literal["cached", "computed", "resumed", "running", "failed"]
"""Status of a task in a run; resumed: computed again for its state, which had not been kept."""
STATUSES: dict[str, Status] = {"cached": "cached", "finished": "computed", "failed": "failed", "started": "running"}
"""By the kind of an event."""


@dataclass(frozen=True, repr=False)
class Plan:
    """Planned evaluation of every node and frame, each after those it needs."""

    entries: tuple[Entry, ...]
    records: Mapping[Task, Record]  # of cached results: inputs, time and duration of computation
    stopped: dict[str, str]  # stopped variants of a wedge, with reasons

    @property
    def missing(self) -> "Plan":
        """The same plan without cached results."""
        return replace(self, entries=tuple(entry for entry in self if entry.status != "cached"))

    def document(self) -> dict[str, Any]:
        """Describe the plan as a JSON document."""
        tasks = [entry.task._asdict() | {"status": entry.status, "reason": entry.reason} for entry in self]
        return {"tasks": tasks, "stopped": self.stopped}

    def __iter__(self) -> Iterator[Entry]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __repr__(self) -> str:
        """Write a table: node, frames, and planned state; then the totals."""
        counts = Counter(entry.status for entry in self.entries)
        waiting = f", up to {counts['depends']:,} more, depending on these results" if counts["depends"] else ""
        total = f"{plural(counts['run'], 'result')} to compute{waiting}, {counts['cached']:,} cached"
        return f"{table(plan_rows(self.entries), '<<<')}\n{total}{stop_lines(self.stopped)}"


def plan_rows(entries: Iterable[Entry]) -> list[tuple[str, str, str]]:
    """Fold the frames of each node with the same planned state: node, frames, state with reason."""
    groups: dict[tuple[str, str], list[int]] = {}
    for entry in entries:
        state = f"will run: {entry.reason}" if entry.status == "run" else entry.status
        if entry.status == "depends":  # equal for similar frames
            state = f"depends on {entry.reason.partition('@')[0]}"
        frames = groups.setdefault((entry.task.node, state), [])
        frames += [] if entry.task.frame is None else [entry.task.frame]
    rows = []
    known = set[str]()
    for (node, state), frames in groups.items():
        rows.append(("" if node in known else node, fold_frames(frames), state))
        known.add(node)
    return rows


def stop_lines(stopped: dict[str, str]) -> str:
    return "".join(f"\nstopped: {variant}: {why}" for variant, why in stopped.items())


class Recorder:
    """Receiver of the events of a run: counts them, collects warnings, and passes every event on.

    warnings  tasks by node and message, in the order in which they came
    statuses  what became of every task that was reached
    """

    def __init__(self, graph: Graph, jobs: int, pass_on: Callable[[Event], object] | None = None) -> None:
        self.progress = Progress(graph, jobs)
        self.warnings: dict[tuple[str, str], list[Task]] = {}
        self.statuses: dict[Task, Status] = {}
        self._established: set[Task] = set()
        self._pass_on = pass_on

    def __call__(self, event: Event) -> None:
        self.progress.update(event)
        if event.kind == "warning" and event.task is not None:
            self.warnings.setdefault((event.task.node, event.message), []).append(event.task)
        if event.task is not None and event.kind in STATUSES:
            again = event.kind == "finished" and event.task in self._established
            self.statuses[event.task] = "resumed" if again else STATUSES[event.kind]
            self._established |= {event.task} if event.kind in ("cached", "finished") else set()
        if self._pass_on is not None:
            self._pass_on(event)


def fault_document(fault: BadInput) -> dict[str, Any]:
    """Describe a fault as a JSON document; node and setting are None where they are unknown."""
    place = fault.where if isinstance(fault.where, Location) else Location("")
    return {
        "what": fault.what,
        "where": None if fault.where is None else str(fault.where),
        "right": fault.right,
        "node": place.node,
        "setting": ".".join(place.names) or None,
    }


class ResultReader(Protocol):
    """A shot whose results can be read."""

    @property
    def cache(self) -> Path: ...

    def get(self, target: str, *, frames: FrameSet = None) -> Any: ...


@dataclass(frozen=True, repr=False)
class Run:
    """A run that has ended."""

    shot: ResultReader  # shot with the settings of the run
    graph: Graph  # part of the graph that was run
    frames: tuple[int, ...]  # requested frames
    outcome: Outcome  # counts, failures, published files, seconds by node
    progress: dict[str, NodeProgress]  # number of results by node: total, evaluated, cached
    warnings: dict[tuple[str, str], list[Task]]  # tasks by node and message, in order of time
    statuses: dict[Task, Status]  # status of every task that was reached
    seconds: float  # duration of the run [s]
    stopped: dict[str, str]  # stopped variants of a wedge, with reasons

    @property
    def ok(self) -> bool:
        """Whether all requested results have been computed and published."""
        return self.outcome.exit_code == 0

    @property
    def failures(self) -> tuple[Failure, ...]:
        """Failed tasks: task, kind of failure, message, traceback."""
        return self.outcome.failures

    def get(self, target: str) -> Any:
        """Read a result of this run, as `Shot.get`."""
        return self.shot.get(target, frames=self.frames)

    def __repr__(self) -> str:
        return "\n".join([self.summary, *self.warning_lines(), *self.failure_lines()])

    @property
    def summary(self) -> str:
        """A table of time by node, and how much of it compiled kernels; the totals; paths of published files."""
        outcome = self.outcome
        spent = {"seconds": outcome.seconds, "processor": outcome.processor, "compiling": outcome.compiled}
        if not any(outcome.compiled.values()):
            del spent["compiling"]
        rows = [("node", "computed", "cached", *spent)]
        for name, node in self.progress.items():
            times = (f"{seconds[name]:.2f}" if seconds.get(name) else "" for seconds in spent.values())
            rows.append((name, str(node.evaluated or ""), str(node.cached or ""), *times))
        total = (
            f"{plural(outcome.evaluated, 'result')} computed, {outcome.cached:,} cached, in {duration(self.seconds)}"
        )
        return (
            f"{table(rows, '<>>>>>'[: len(rows[0])])}\n{total}{stop_lines(self.stopped)}\n\n{self._places()}".rstrip()
        )

    def warning_lines(self, fewest: int = 1) -> list[str]:
        """List the warnings that occurred at least `fewest` times, with the frames."""
        return [
            f"warning: {folded(node, tasks)}: {message}"
            for (node, message), tasks in self.warnings.items()
            if len(tasks) >= fewest
        ]

    def failure_lines(self) -> list[str]:
        """List the failures, and whether the run was interrupted."""
        interrupted = ["interrupted; computed results are kept, and the same run resumes"]
        return [f"failed: {failure}" for failure in self.failures] + interrupted * self.outcome.interrupted

    def _places(self) -> str:
        """List the published files by node."""
        nodes = self.graph.nodes.values()
        if not any(node.publish for node in nodes):
            return f"nothing is published; results are in {shown(self.shot.cache)}, see `hairpipe get`"
        published = set(self.outcome.published)
        lines = []
        for node in nodes:
            frames = self.frames if node.per_frame else (None,)
            paths = [path for frame in frames if (path := node.publish_path(frame)) and str(path) in published]
            if paths:
                more = f" ... {paths[-1].name} ({len(paths)} files)" if len(paths) > 1 else ""
                lines.append((node.name, shown(paths[0]) + more))
        return table(lines, "<<")


def folded(node: str, tasks: list[Task]) -> str:
    frames = fold_frames(task.frame for task in tasks if task.frame is not None)
    return f"{node}@{frames}" if frames else node


VERDICTS = {"cached": "cached", "run": "will run", "depends": "depends on"}


@dataclass(frozen=True, repr=False)
class Explanation(planner.Explanation):
    """The plan of one task in detail, printed as a table of settings, inputs and outputs; fields as in the planner."""

    def __repr__(self) -> str:
        """Write the planned state of the task with its reason, the parts of its key, and its result if there is one."""
        status = self.entry.status
        why = self.reasons if self.entry.status != "cached" else ()
        lines = [f"{self.entry.task}: {VERDICTS[status]}" + (f" {why[0]}" if status == "depends" else "")]
        lines += [f"  {reason}" for reason in why] if status == "run" else []
        if self.parts is not None:
            lines += ["", table(list(made_of(self.parts)), "<<<")]
        if self.record is not None:
            lines += ["", table(outputs(self.record, self.thinned), "<>>"), "", evaluated(self.record)]
        return "\n".join(lines)

    def document(self) -> dict[str, Any]:
        """Describe the result as a JSON document."""
        record = self.record
        kept = {} if record is None else record.outputs
        return self.entry.task._asdict() | {
            "status": self.entry.status,
            "reasons": [] if self.entry.status == "cached" else list(self.reasons),
            "key": self.entry.key,
            "made_of": self.parts,
            "outputs": record and {n: o._asdict() | {"kept": n not in self.thinned} for n, o in kept.items()},
            "seconds": record and record.seconds,
            "processor": record and record.processor,
            "created": record and record.created,
            "processor_class": record and record.processor_class,
            "threading_layer": record and record.threading_layer,
            "warnings": list(record.warnings) if record else [],
        }


def made_of(parts: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    yield "type", parts["type"], ""
    yield "code", "", parts["code"]
    yield from (("setting", name, text) for name, text in spread(parts["settings"]))
    yield from (("input", name, written(value)) for name, value in parts["inputs"].items())
    times = (parts["time"] or {}).items()
    yield from (("time", name, str(value["key"] if name == "origin" else value)) for name, value in times)


def spread(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """List settings by dotted name, as in a graph file; an omitted group is absent."""
    for name, value in settings.items():
        if isinstance(value, Mapping):
            yield from spread(value, f"{prefix}{name}.")
        else:
            yield prefix + name, "absent" if value is None else json.dumps(value)


def written(value: Any) -> str:
    """Write the objects of a socket: one, those of the previous and the current frame, or the number of frames."""
    if value is None:
        return "not connected"
    if not isinstance(value, list):
        return value
    if isinstance(value[0], str):
        previous, current = value
        return f"{current} (previous frame: {'the same' if previous == current else previous})"
    return f"{len(value)} frames"


def outputs(record: Record, thinned: frozenset[str]) -> list[tuple[str, str, str]]:
    sizes = {name: "not kept" if name in thinned else size(output.size) for name, output in record.outputs.items()}
    return [(f"output {name}".rstrip(), sizes[name], output.object) for name, output in record.outputs.items()]


def evaluated(record: Record) -> str:
    when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.created))
    on = f" on {record.processor_class}" if record.processor_class else ""
    on += f", threads by {record.threading_layer}" if record.threading_layer else ""
    busy = "" if record.processor is None else f", processor {duration(record.processor)}"
    warnings = [one_line(f"warning: {warning}") for warning in record.warnings]
    return "\n".join([f"computed {when} in {duration(record.seconds)}{on}{busy}", *warnings])
