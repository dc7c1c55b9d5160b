"""What came of a run, as text and as a document."""

from dataclasses import dataclass
from typing import Any

from hairpipe.cli.watch import Watch
from hairpipe.api.formatting import duration, plural, say, shown, table
from hairpipe.graph.file.frameset import fold_frames
from hairpipe.graph.file.graph import Graph, Node
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.run.events import Failure, Outcome
from hairpipe.graph.store.store import Store


@dataclass(frozen=True)
class Done:
    """A run that has ended.

    frames   that were asked for
    seconds  that it took altogether [s]
    """

    graph: Graph
    store: Store
    frames: tuple[int, ...]
    outcome: Outcome
    watch: Watch
    seconds: float


def text(done: Done) -> str:
    """Write the seconds of every node, those of the processor beside those that passed, and where the results are."""
    outcome = done.outcome
    rows = [("node", "computed", "cached", "seconds", "processor")]
    for name, node in done.watch.progress.nodes.items():
        seconds, worked = (f"{t[name]:.2f}" if name in t else "" for t in (outcome.seconds, outcome.processor))
        rows.append((name, str(node.evaluated or ""), str(node.cached or ""), seconds, worked))
    total = f"{plural(outcome.evaluated, 'result')} computed, {outcome.cached:,} cached, in {duration(done.seconds)}"
    return f"{table(rows, '<>>>>')}\n{total}\n\n{places(done)}".rstrip()


def places(done: Done) -> str:
    """Say where the published files are, node by node."""
    lines = [(node.name, found) for node in done.graph.nodes.values() if (found := place(node, done))]
    if lines or any(node.publish for node in done.graph.nodes.values()):
        return table(lines, "<<")
    return f"nothing is published; results are in {shown(done.store.root)}, see `hairpipe get`"


def place(node: Node, done: Done) -> str:
    """Say where the files of a node are; empty where none was published."""
    published = set(done.outcome.published)
    frames = done.frames if node.per_frame else (None,)
    paths = [path for frame in frames if (path := node.publish_path(frame)) and str(path) in published]
    if len(paths) < 2:
        return shown(paths[0]) if paths else ""
    return f"{shown(paths[0])} ... {paths[-1].name} ({len(paths)} files)"


def say_faults(done: Done, verbose: bool) -> None:
    """Say what failed, what was not reached, and which warnings came more than once."""
    outcome = done.outcome
    for (node, message), tasks in done.watch.warnings.items():
        if len(tasks) > 1:
            say(f"warning: {folded(node, tasks)}: {message}")
    for failure in outcome.failures:
        if verbose and failure.traceback:
            for line in ("", str(failure.task), *failure.traceback.split("\n")):
                say(line)
    if outcome.failures:
        names = ", ".join(str(failure.task) for failure in outcome.failures)
        missed = f"; {plural(outcome.blocked, 'result')} not reached" if outcome.blocked else ""
        raised = any(failure.kind in ("node", "diverged") and failure.traceback for failure in outcome.failures)
        hint = "; -v shows where in the code" if raised and not verbose else ""
        say(f"hairpipe: {names} failed{missed}{hint}")
    if outcome.interrupted:
        say("hairpipe: interrupted; what was computed is kept, the same command goes on from there")


def folded(node: str, tasks: list[Task]) -> str:
    """Write a node at some of its frames."""
    return f"{node}@{fold_frames(task.frame for task in tasks if task.frame is not None)}"


def document(done: Done) -> dict[str, Any]:
    """Describe a run as a JSON document."""
    nodes = done.watch.progress.nodes
    return {
        "graph": str(done.graph.path),
        "cache": str(done.store.root),
        "frames": list(done.frames),
        "exit_code": done.outcome.exit_code,
        "interrupted": done.outcome.interrupted,
        "seconds": done.seconds,
        "evaluated": done.outcome.evaluated,
        "cached": done.outcome.cached,
        "blocked": done.outcome.blocked,
        "nodes": {
            name: {
                "total": node.total,
                "evaluated": node.evaluated,
                "cached": node.cached,
                "seconds": done.outcome.seconds.get(name, 0.0),
                "processor": done.outcome.processor.get(name, 0.0),
            }
            for name, node in nodes.items()
        },
        "published": list(done.outcome.published),
        "failures": [failure.task._asdict() | described(failure) for failure in done.outcome.failures],
        "warnings": [
            {"node": node, "frames": [task.frame for task in tasks], "message": message}
            for (node, message), tasks in done.watch.warnings.items()
        ],
    }


def described(failure: Failure) -> dict[str, str]:
    """Describe what went wrong."""
    return {"kind": failure.kind, "message": failure.message, "traceback": failure.traceback}
