"""Plans of runs, with reasons, and the values of results. A plan evaluates no node and writes no file."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

from hairpipe.engine.file.graph import Graph
from hairpipe.engine.plan.key import Resolver, differences
from hairpipe.engine.plan.scans import end_known_scan
from hairpipe.engine.plan.tasks import Task, sources
from hairpipe.engine.store.digest import Parts, action_key
from hairpipe.engine.store.lease import recall_failure
from hairpipe.engine.store.store import LostObject, Record, Store
from hairpipe.engine.store.values import Values
from hairpipe.errors import BadInput

Status = Literal["cached", "run", "depends"]


@dataclass(frozen=True)
class Entry:
    """The planned evaluation of a task.

    status  cached: the result is in the store; run: it will be evaluated; depends: it depends on changes of inputs
    reason  of `run`: the failure, or the first difference to the latest result; of `depends`: the previous task
    key     None if inputs are unknown
    """

    task: Task
    status: Status
    reason: str = ""
    key: str | None = None


@dataclass(frozen=True)
class Explanation:
    """The plan of one task in detail."""

    entry: Entry
    parts: Parts | None  # parts of the key; None while an input is unknown
    reasons: tuple[str, ...]  # reason of the entry, and all differences to the latest result of this node and frame
    record: Record | None  # the result, if it is in the store
    thinned: frozenset[str] = frozenset()  # removed outputs: states from which a scan continues


def check_task(graph: Graph, task: Task) -> None:
    per_frame = graph.node(task.node).per_frame
    first, last = graph.frames
    if not per_frame and task.frame is not None:
        raise BadInput(f"'{task.node}' has one value for the shot", where=graph.path, right=task.node)
    if per_frame and task.frame is None:
        raise BadInput(f"'{task.node}' has a value per frame", where=graph.path, right=f"{task.node}@{first}")
    if task.frame is not None and not graph.begin <= task.frame <= last:
        what = f"'{task}': frame {task.frame} is outside the graph"
        raise BadInput(what, where=graph.path, right=f"frames {first}-{last}")


def plan(graph: Graph, store: Store, frames: Iterable[int] | None = None) -> list[Entry]:
    """Plan every node and frame, in order of dependency; BadInput as for a run."""
    return Planner(graph, store, frames).entries()


def explain(graph: Graph, store: Store, task: Task, frames: Iterable[int] | None = None) -> Explanation:
    """Explain the key of a task, and its differences to the latest result."""
    check_task(graph, task)
    planner = Planner(graph.upto([task.node]), store, frames)
    entry = next((entry for entry in planner.entries() if entry.task == task), None)
    if entry is None:
        raise BadInput(f"'{task}' is not among the selected frames", where=graph.path)
    parts = planner.resolver.parts(task) if entry.status != "depends" else None
    found = [entry.reason, *(planner.reasons(task, parts) if parts is not None else ())]
    record = planner.resolver.results.get(task)
    outputs = record.outputs if record is not None else {}
    thinned = frozenset(name for name, output in outputs.items() if not store.has(output.object))
    return Explanation(entry, parts, tuple(dict.fromkeys(filter(None, found))), record, thinned)


class Planner:
    """Visits the tasks of a graph in the order of a run, without evaluation."""

    def __init__(self, graph: Graph, store: Store, frames: Iterable[int] | None) -> None:
        self.store = Store(store.root, read_only=True)
        self.graph = graph
        try:
            self.resolver = Resolver(graph, self.store, graph.select(frames))
        except OSError as error:
            raise BadInput(f"the store cannot be used: {error}", where=store.root) from None
        self.latest = {name: self.store.latest(graph.name, name) for name in graph.nodes}

    def entries(self) -> list[Entry]:
        entries = {task: self.entry(task) for task in self.resolver.tasks}
        pending = [task for task, entry in entries.items() if entry.status != "cached"]
        while pending:
            for producer in self.gone(pending.pop()):
                if entries[producer].status == "cached":
                    reason = "its full state, needed to continue, was not kept"
                    entries[producer] = Entry(producer, "run", reason, entries[producer].key)
                    pending.append(producer)
        return list(entries.values())

    def entry(self, task: Task) -> Entry:
        results = self.resolver.results
        waiting = [s.task for s in sources(self.resolver.tasks[task]) if s.task not in results]
        if waiting:
            other = next((needed for needed in waiting if needed.node != task.node), waiting[0])
            return Entry(task, "depends", str(other))
        parts = self.resolver.parts(task)
        key = action_key(parts)
        record = self.resolver.find(task, key)
        if record is None and end_known_scan(self.resolver, task, key) is not None:
            return Entry(task, "run", "diverged; frames before were used", key)
        if record is None:
            failure = recall_failure(self.store, key)
            reason = next(iter(self.reasons(task, parts)), "its key differs") if failure is None else str(failure)
            return Entry(task, "run", reason, key)
        results[task] = record
        return Entry(task, "cached", "", key)

    def reasons(self, task: Task, parts: Parts) -> list[str]:
        """List all differences to the latest result of this node and frame."""
        known = self.latest[task.node]
        key = known.get("" if task.frame is None else str(task.frame))
        if key is None:
            return ["new frame" if known else "never evaluated"]
        if key == action_key(parts):
            return [] if self.resolver.find(task, key) else ["its result is missing or damaged"]
        record = self.store.record(key)
        if record is None:
            return ["its latest result is missing"]
        return list(differences(record.parts, parts, self.resolver.codes[task.node].parts, self.store))

    def gone(self, task: Task) -> set[Task]:
        """Return cached tasks with missing objects that this task needs."""
        needed = {source for source in sources(self.resolver.tasks[task]) if source.task in self.resolver.results}
        gone = {source for source in needed if not self.store.has(self.resolver.object(source))}
        return {source.task for source in gone if not self.resolver.leases.is_in_memory(self.resolver.object(source))}


def read_result(
    graph: Graph,
    store: Store,
    task: Task,
    output: str | None = None,
    frames: Iterable[int] | None = None,
) -> Any:
    """Read a result from the store: a value of its type, or a File; BadInput where it has not been computed.

    output  of a node with several; without one, the only one or the first
    frames  of the run that has computed it, all for None
    """
    return read_value(graph, store, task, explain(graph, store, task, frames).record, output)


def read_value(graph: Graph, store: Store, task: Task, record: Record | None, output: str | None = None) -> Any:
    """Read an output of a task from the store; BadInput as for `fetch`.

    record  of the task; None where it has not been computed
    """
    node = graph.nodes[task.node]
    name = graph.output(task.node, output)
    if record is None:
        raise BadInput(f"'{task}' has not been computed", where=graph.path, right=f"hairpipe run --to {task.node}")
    if not store.has(record.outputs[name].object):
        what = f"output '{name}' of '{task}' was not kept"
        raise BadInput(what, where=store.root, right="a run with checkpoint = 1 and another --cache")
    try:
        return Values(store, 0).get(record.outputs[name].object, node.type.outputs[name])
    except LostObject:
        right = "hairpipe run computes it again"
        raise BadInput(f"'{task}' is not in the store any more", where=store.root, right=right) from None
