"""Brings every task of a run from waiting to established: decides what is ready, and feeds the workers.

One rule covers a cold start, a resumed one, thinned states and damaged objects: a task that needs an object which is
not there sends its producer back to work, and that one may in turn send its own.
"""

from collections import Counter, defaultdict, deque
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.node.files import File
from hairpipe.graph.plan.checkpoints import Thinner
from hairpipe.graph.plan.divergence import end, ending_note
from hairpipe.graph.plan.resolve import Resolver
from hairpipe.graph.plan.tasks import Task, sources
from hairpipe.graph.run.events import Event, Failure, Kind, Options, Outcome, Report
from hairpipe.graph.run.pool import Lane, Pool
from hairpipe.graph.run.publish import Publisher
from hairpipe.graph.run.queue import Queue
from hairpipe.graph.store.key import action_key
from hairpipe.graph.store.locks import KeyLocks
from hairpipe.graph.store.record import Record, from_fields
from hairpipe.graph.store.store import LostObject, Store

POLL = 0.1
"""How often a task that another process is at is looked at again [s]."""
HEALED = "compiled kernels were damaged, and are compiled again"
KEPT = "what lies where it is published is not hairpipe's, and stays unless it comes out equal (--force overwrites it)"
MOST_LOSSES = 10
"""How often a task may find its inputs damaged before it is given up: the disk is failing."""


class Scheduler:
    """The state of one run: a task is waiting for others, ready, at a worker, established, or failed."""

    def __init__(self, graph: Graph, store: Store, frames: tuple[int, ...], options: Options, report: Report) -> None:
        self.graph, self.store, self.options, self.report = graph, store, options, report
        self.resolver = Resolver(graph, store, frames)
        self.thinner = Thinner(self.resolver)
        self.publisher = Publisher(store, graph, options.publish_root, force=options.force)
        self.selected = frozenset(frames)
        modules = [node.type.module for node in graph.nodes.values()]
        self.pool = Pool(store.root, options.codec, graph.folder, options.jobs, modules, self.resolver.reader)
        self.locks = KeyLocks(store.root / "lock")
        self.queue = Queue(graph)
        self.agenda: deque[Task] = deque()
        self.unmet: dict[Task, set[Task]] = {}
        self.waiters: dict[Task, list[Task]] = {}
        self.elsewhere: list[Task] = []
        self.keys: dict[Task, str] = {}
        self.failures: dict[Task, Failure] = {}
        self.ended: set[Task] = set()
        self.losses: Counter[Task] = Counter()
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.processor: defaultdict[str, float] = defaultdict(float)
        self.published: list[str] = []
        self.told: set[tuple[str, str]] = set()

    def carry_out(self) -> Outcome:
        """Run until everything is established, or nothing more can be."""
        totals = Counter(task.node for task in self.resolver.tasks)
        self.report(Event("begun", totals=tuple(totals.items())))
        for task in self.resolver.tasks:
            path = self.publish_path(task)
            if path is not None and self.publisher.is_kept(path):
                self.report(Event("warning", task, message=KEPT))
        for task, inputs in self.resolver.tasks.items():
            self.wait(task, {source.task for source in sources(inputs)})
        interrupted = False
        try:
            self.loop()
            self.thinner.finish()
        except KeyboardInterrupt:
            interrupted = True
        finally:
            self.pool.close()
            self.locks.close()
            self.note_latest()
        return self.outcome(interrupted)

    def loop(self) -> None:
        """Alternate between what can be decided here and what the workers report."""
        while True:
            self.settle()
            if not self.stopping:
                self.dispatch()
            if self.agenda:
                continue
            if not self.pool.busy and (self.stopping or not self.elsewhere):
                return
            for task, reply in self.pool.receive(POLL if self.elsewhere else None):
                self.finish(task, reply)
            self.agenda.extend(self.elsewhere)
            self.elsewhere.clear()

    @property
    def stopping(self) -> bool:
        """Whether nothing new is begun: after a failure, unless asked to keep going; always on a full disk."""
        going = self.options.keep_going and all(failure.kind != "disk" for failure in self.failures.values())
        return bool(self.failures) and not going

    def wait(self, task: Task, on: set[Task]) -> None:
        """Consider a task once these are established."""
        if not on:
            self.agenda.append(task)
        self.unmet[task] = on
        for other in on:
            self.waiters.setdefault(other, []).append(task)

    def settle(self) -> None:
        """Decide for every task whose inputs are known: it is established, has to wait, or is ready."""
        while self.agenda:
            task = self.agenda.popleft()
            self.keys[task] = action_key(self.resolver.parts(task))
            record = self.resolver.find(task, self.keys[task])
            if record:
                self.store.touch(record.key)
                self.establish(task, record, "cached")
                continue
            gone = self.resolver.missing(task)
            if gone:
                self.demand(task, gone)
            else:
                self.queue.push(task)

    def demand(self, task: Task, gone: set[Task]) -> None:
        """Send producers back to work whose objects are not in the store, and wait for them."""
        for producer in gone:
            if producer not in self.waiters:
                self.resolver.demanded.add(producer)
                self.agenda.append(producer)
        self.wait(task, gone)

    def dispatch(self) -> None:
        """Give ready tasks to free workers."""
        lanes: tuple[Lane, Lane] = ("wide", "narrow")
        for lane in lanes:
            while self.pool.free(lane):
                task = next(self.queue.take(lane, wide_is_free=self.pool.free("wide")), None)
                if task is None:
                    break
                self.begin(lane, task)

    def begin(self, lane: Lane, task: Task) -> None:
        """Give a task to a worker, unless another process is at it or has just done it."""
        if not self.pool.members:
            self.store.check_writable()
        parts = self.resolver.parts(task)
        key = self.keys[task] = action_key(parts)
        if not self.locks.acquire(key):
            self.elsewhere.append(task)
            return
        if self.resolver.find(task, key):
            self.locks.release(key)
            self.agenda.append(task)
            return
        node = self.graph.nodes[task.node]
        job = {
            "key": key,
            "node": task.node,
            "frame": task.frame,
            "type": node.type.name,
            "parts": parts,
            "settings": self.graph.settings(node),
            "inputs": parts["inputs"],
            "time": {"frame": self.resolver.frame_of(task), "fps": self.graph.fps},
            "files": self.resolver.files[node.name],
        }
        self.pool.send(lane, task, job)
        self.tell(task, self.pool.said)
        self.report(Event("started", task))

    def finish(self, task: Task, reply: dict[str, Any]) -> None:
        """Take in what a worker says."""
        self.locks.release(self.keys[task])
        self.tell(task, [HEALED] if reply.get("healed") else [])
        if "record" in reply:
            self.establish(task, from_fields(reply["record"]), "finished")
            self.thinner.follow(task)
        elif "failure" in reply:
            self.fail(Failure(task, **reply["failure"]))
        elif self.may_retry(task):
            producers = {source.task for source in sources(self.resolver.tasks[task])}
            held = {p: {name for name, _ in self.resolver.results[p].objects()} for p in producers}
            self.demand(task, {p for p in producers if reply["lost"] in held[p]})

    def tell(self, task: Task, messages: Iterable[str], node: str = "") -> None:
        """Report warnings that are not of a single frame: each once a run, or once for this node."""
        for message in messages:
            if (node, message) not in self.told:
                self.told.add((node, message))
                self.report(Event("warning", task, message=message))

    def may_retry(self, task: Task) -> bool:
        """Whether a task that met a damaged object is tried once more; it fails where that never ends."""
        self.losses[task] += 1
        if self.losses[task] > MOST_LOSSES:
            self.fail(Failure(task, "disk", f"objects are damaged again and again in {self.store.root}"))
        return self.losses[task] <= MOST_LOSSES

    def establish(self, task: Task, record: Record, how: Kind) -> None:
        """Take a result as known, publish it, and wake those that wait for it."""
        before = self.resolver.results.get(task)
        self.resolver.results[task] = record
        self.thinner.take(task, record, before)
        if how == "finished":
            self.counts["evaluated"] += 1
            self.seconds[task.node] += record.seconds
            self.processor[task.node] += record.processor or 0.0
        elif before is None:
            self.counts["cached"] += 1
        self.report(Event(how, task, record.seconds))
        self.tell(task, record.prepare_warnings, task.node)
        for message in record.warnings if before is None else ():
            self.report(Event("warning", task, message=message))
        if before is not None and before.outputs != record.outputs:
            self.report(Event("warning", task, message="gave another result than before: the node is not reproducible"))
        if not self.publish(task, record):
            return
        for waiter in self.waiters.pop(task, ()):
            self.unmet[waiter].discard(task)
            if not self.unmet[waiter]:
                self.agenda.append(waiter)

    def publish_path(self, task: Task) -> Path | None:
        """Where the file of a task is published; None where it is not, or not in this run."""
        selected = task.frame is None or task.frame in self.selected
        return self.graph.nodes[task.node].publish_path(task.frame) if selected else None

    def publish(self, task: Task, record: Record) -> bool:
        """Publish the file of a task; False where its object turned out damaged and the task was sent back."""
        path = self.publish_path(task)
        if path is None:
            return True
        outputs = self.graph.nodes[task.node].type.outputs
        name = next(name for name, kind in outputs.items() if kind is File)
        try:
            if self.publisher.publish(task, record.outputs[name], path):
                self.report(Event("published", task, message=str(path)))
            self.published.append(str(path))
        except LostObject:
            if self.may_retry(task):
                self.resolver.demanded.add(task)
                self.agenda.append(task)
            return False
        except BadInput as error:
            self.fail(Failure(task, "publish", f"cannot publish to {error}"))
        except OSError as error:
            message = f"cannot publish to {path}: {error.strerror or error}"
            self.fail(Failure(task, "publish", message))
        return True

    def fail(self, failure: Failure) -> None:
        """Note a failure; what waits for the task is never woken, but for those who take what was reached."""
        ending = end(self.resolver, failure.task) if failure.kind == "diverged" else None
        if ending is not None:
            self.ended |= ending.lost
            self.store.note(ending_note(self.keys[failure.task]), failure.message)
            self.report(Event("warning", failure.task, message=f"{failure.message}; what came before is used"))
            for task in ending.takers:
                self.unmet[task] -= ending.lost
                if not self.unmet[task]:
                    self.agenda.append(task)
            return
        self.failures[failure.task] = failure
        self.report(Event("failed", failure.task, message=failure.message))

    def note_latest(self) -> None:
        """Note which results are the latest, for the differences that a plan shows."""
        keys: dict[str, dict[str, str]] = {}
        for task, record in self.resolver.results.items():
            keys.setdefault(task.node, {})["" if task.frame is None else str(task.frame)] = record.key
        for node, latest in keys.items():
            with suppress(OSError):  # on a full disk the differences are lost, nothing else
                self.store.set_latest(self.graph.name, node, latest)

    def outcome(self, interrupted: bool) -> Outcome:
        """Sum up."""
        reached = self.resolver.results.keys() | self.failures.keys() | self.ended
        return Outcome(
            evaluated=self.counts["evaluated"],
            cached=self.counts["cached"],
            blocked=len(self.resolver.tasks.keys() - reached),
            failures=tuple(self.failures.values()),
            published=tuple(self.published),
            seconds=dict(self.seconds),
            processor=dict(self.processor),
            interrupted=interrupted,
        )
