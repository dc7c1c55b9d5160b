"""Runs a graph: decides which tasks are ready, and hands them to the workers.

One rule covers a cold start, a resumed run, thinned states and damaged objects: where a task needs an object that is
missing, the task that produced it is scheduled again, which may in turn reschedule its own producers.

The engine that the options of a run name: this machine, or the workers of a Dask cluster.
"""

import heapq
import time
from collections import Counter, defaultdict, deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

from hairpipe.engine.file.graph import Graph, origin
from hairpipe.engine.hosts.dask_engine import DaskEngine
from hairpipe.engine.hosts.host import MACHINE, Host, Job, LocalEngine, Reply, Slots
from hairpipe.engine.hosts.offer import Offer, sent_offer
from hairpipe.engine.node.declare import File
from hairpipe.engine.plan.key import Resolver, state_of
from hairpipe.engine.plan.scans import Thinner, divergence_note, end_scan, state_objects
from hairpipe.engine.plan.tasks import Portion, Task, is_beyond, order_of, sources
from hairpipe.engine.run.events import Event, Failure, Kind, Options, Outcome, Report
from hairpipe.engine.run.publish import Publisher
from hairpipe.engine.store.digest import action_key
from hairpipe.engine.store.store import LostObject, Record, Store, records
from hairpipe.errors import BadInput


def make_engine(resolver: Resolver, options: Options) -> LocalEngine | DaskEngine:
    """Make the engine of a run; BadInput for a scheduler without TLS that is not allowed.

    resolver  of the run: its store, and the code behind its keys, which a host on this machine need not digest again
    options   number of processes and spare ones on this machine, or the address of a scheduler
    """
    codes = {node.type.module: resolver.codes[node.name].digest for node in resolver.graph.nodes.values()}
    modules = tuple(sorted(codes))
    if options.scheduler is not None:
        send = partial(sent_offer, resolver.store, resolver.graph.folder, modules)
        return DaskEngine(options.scheduler, send, insecure=options.insecure)
    offer = Offer(str(resolver.store.root), str(resolver.graph.folder), modules)
    threads = max(1, options.jobs // options.scans)
    host = Host(offer, MACHINE, threads, resolver.reader, codes, options.spare)
    return LocalEngine(host, Slots(options.scans, options.jobs))


POLL = 0.1
"""Interval at which a task that another process is evaluating is checked again [s]."""
DIFFERS = "the result differs from the previous one: the node is not reproducible"
HEALED = "compiled kernels were damaged, and are compiled again"
KEPT = "the existing file is not from hairpipe, and is kept unless its new content is equal (--force overwrites it)"
MOST_LOSSES = 10
"""Number of times that a task may find its inputs damaged before it fails: the disk is failing."""


def run(
    graph: Graph,
    store: Store,
    frames: Iterable[int] | None = None,
    options: Options | None = None,
    report: Report = lambda event: None,
) -> Outcome:
    """Establish all nodes of a graph at these frames (all for None), publish files, thin the states of scans.

    A scan is evaluated from the first frame of the graph on, whatever is selected. Use `graph.upto` to stop at a
    node. Raises BadInput before anything is evaluated; a failure of a node is part of the outcome. Ctrl-C stops the
    workers at once and returns the outcome so far: every complete result is kept.
    """
    numbers = graph.select(frames)
    try:
        store.sweep()
        return Scheduler(graph, store, numbers, options or Options(), report).run()
    except OSError as error:
        raise BadInput(f"the store cannot be used: {error}", where=store.root) from None


class Scheduler:
    """The state of one run. A task is waiting for others, ready, at a worker, established, or failed.

    Tasks with equal keys are twins: one is evaluated, and the others wait for it.
    """

    def __init__(self, graph: Graph, store: Store, frames: tuple[int, ...], options: Options, report: Report) -> None:
        self.graph, self.store, self.options, self.report = graph, store, options, report
        self.resolver = Resolver(graph, store, frames)
        self.thinner = Thinner(self.resolver)
        self.publisher = Publisher(store, graph, options.publish_root, force=options.force)
        self.portion = Portion(graph, self.resolver.tasks, frames, options.only)
        self.engine = make_engine(self.resolver, options)
        self.at_work: dict[str, Task] = {}
        self.queue = Queue(graph, options.judge.judged)
        self.agenda: deque[Task] = deque()
        self.unmet: dict[Task, set[Task]] = {}
        self.waiters: dict[Task, list[Task]] = {}
        self.elsewhere: list[Task] = []
        self.twins: defaultdict[str, list[Task]] = defaultdict(list)
        self.keys: dict[Task, str] = {}
        self.failures: dict[Task, Failure] = {}
        self.ended: set[Task] = set()
        self.losses: Counter[Task] = Counter()
        self.failed_at: defaultdict[Task, set[str]] = defaultdict(set)
        self.is_checked = False
        self.looked = self.worked = time.monotonic()
        self.counts: Counter[str] = Counter()
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.processor: defaultdict[str, float] = defaultdict(float)
        self.compiled: defaultdict[str, float] = defaultdict(float)
        self.published: list[str] = []
        self.reported: set[tuple[str, str]] = set()
        self.limits: Mapping[str, int] = {}

    def run(self) -> Outcome:
        totals = Counter(origin(task.node) for task in self.resolver.tasks)
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
            self.thinner.thin_all()
        except KeyboardInterrupt:
            interrupted = True
        finally:
            self.engine.cancel(self.at_work)
            self.engine.close()
            self.note_latest()
        return self.outcome(interrupted)

    def loop(self) -> None:
        """Alternate between decisions of the scheduler and replies of the workers."""
        while True:
            self.settle()
            if not self.stopping:
                self.dispatch()
            if self.agenda:
                continue
            if not self.at_work and (self.stopping or not self.elsewhere or self.has_waited):
                if not self.stopping and (task := self.queue.first()):
                    self.fail(Failure(task, "gone", "no machine offers a slot for this node: start one, and run again"))
                return
            for reply in self.engine.replies(POLL if self.elsewhere else None):
                self.agenda.extend(self.twins.pop(reply["key"], ()))
                self.finish(self.at_work.pop(reply["key"]), reply)
            if time.monotonic() - self.looked > POLL:
                self.looked = time.monotonic()
                self.agenda.extend(self.elsewhere)
                self.elsewhere.clear()

    @property
    def has_waited(self) -> bool:
        """Whether nothing was evaluated here for as long as the run waits for other processes."""
        return self.options.wait is not None and time.monotonic() - self.worked > self.options.wait

    @property
    def stopping(self) -> bool:
        """Whether no new task is started: after a failure, unless the run is to keep going; always on a full disk."""
        going = self.options.keep_going and all(failure.kind != "disk" for failure in self.failures.values())
        return bool(self.failures) and not going

    def wait(self, task: Task, on: set[Task]) -> None:
        """Decide on a task once the tasks `on` are established."""
        if not on:
            self.agenda.append(task)
        self.unmet[task] = on
        for other in on:
            self.waiters.setdefault(other, []).append(task)

    def settle(self) -> None:
        """Decide for every task on the agenda, whose inputs are known: it is cached, has to wait, or is ready."""
        while self.agenda:
            task = self.agenda.popleft()
            if is_beyond(task, self.limits):
                continue
            self.keys[task] = action_key(self.resolver.parts(task))
            record = self.resolver.find(task, self.keys[task])
            gone = set() if record else self.resolver.missing(task)
            if gone:  # perhaps since another process has evaluated this task meanwhile, and thinned the states before
                self.store.refresh(self.keys[task])
                record = self.resolver.find(task, self.keys[task])
            if record:
                self.store.touch(record.key)
                self.establish(task, record, "cached")
            elif all(self.portion.computes(needed) for needed in (task, *gone)):
                self.demand(task, gone) if gone else self.queue.push(task)

    def demand(self, task: Task, gone: set[Task]) -> None:
        """Schedule producers again whose objects are missing from the store, and wait for them."""
        for producer in gone:
            if producer not in self.waiters:
                self.resolver.demanded.add(producer)
                self.agenda.append(producer)
        self.wait(task, gone)

    def dispatch(self) -> None:
        """Give ready tasks to free slots."""
        for wide in (True, False):
            while self.queue.first() and not self.agenda:
                slots = self.engine.slots()
                free = slots.wide if wide else slots.narrow
                task = next(self.queue.take(wide=wide, wide_is_free=slots.wide > 0), None) if free > 0 else None
                if task is None:
                    break
                if not is_beyond(task, self.limits):
                    self.begin(task, wide)

    def begin(self, task: Task, wide: bool) -> None:
        if not self.is_checked:
            self.store.check_writable(f"'{task}'")
            self.is_checked = True
        parts = self.resolver.parts(task)
        key = self.keys[task] = action_key(parts)
        if key in self.at_work:
            self.twins[key].append(task)
            return
        if self.resolver.find(task, key):  # an equal task has been evaluated since this one was ready
            self.agenda.append(task)
            return
        node = self.graph.nodes[task.node]
        job = Job(
            key=key,
            node=task.node,
            frame=task.frame,
            type=node.type.name,
            module=node.type.module,
            parts=parts,
            settings=self.graph.settings(node),
            time=self.resolver.time_of(task),
            files=self.resolver.files[node.name],
            outputs=tuple(node.type.outputs),
            spared=None if task in self.resolver.demanded else state_of(node),
            fleeting=None if self.portion.ends(task, self.limits) or self.thinner.must_write(task) else state_of(node),
            wide=wide,
            avoid=tuple(self.failed_at[task]),
        )
        self.at_work[key] = task
        self.engine.submit(job)
        self.report_once(task, self.engine.warnings)
        self.report(Event("started", task))

    def finish(self, task: Task, reply: Reply) -> None:
        self.report_once(task, [HEALED] if reply.get("healed") else [])
        if reply.get("found"):
            self.store.touch(reply["key"])
            self.establish(task, records().validate_python(reply["record"]), "cached")
        elif "record" in reply:
            self.worked = time.monotonic()
            record = records().validate_python(reply["record"])
            self.establish(task, record, "finished")
            if set(reply["held"]).isdisjoint(state_objects(record)):
                self.thinner.thin_behind(task)
        elif "leased" in reply:
            self.elsewhere.append(task)
        elif "failure" in reply:
            failure = Failure(task, **reply["failure"])
            if not self.goes_elsewhere(failure, reply["machine"]):
                self.fail(failure)
        elif self.may_retry(task):
            self.agenda.append(task)

    def goes_elsewhere(self, failure: Failure, machine: str) -> bool:
        """Submit a task again where its machine is to blame: once for a crash, and while machines are left."""
        if failure.kind not in ("crash", "gone", "mismatch"):
            return False
        if failure.kind == "mismatch":
            self.engine.leave_out(machine)
        elif self.failed_at[failure.task]:
            return False
        else:
            self.failed_at[failure.task].add(machine)
        if not self.engine.machines - self.failed_at[failure.task]:
            return False
        self.report_once(failure.task, [f"{failure.message}: other machines go on"])
        self.queue.push(failure.task)
        return True

    def report_once(self, task: Task, messages: Iterable[str], node: str = "") -> None:
        """Report warnings that do not belong to a single frame: once per run, or once per node where one is named."""
        for message in messages:
            if (node, message) not in self.reported:
                self.reported.add((node, message))
                self.report(Event("warning", task, message=message))

    def may_retry(self, task: Task) -> bool:
        """Whether a task that met a damaged object is tried again; after too many attempts it fails."""
        self.losses[task] += 1
        if self.losses[task] > MOST_LOSSES:
            self.fail(Failure(task, "disk", f"repeatedly damaged objects in {self.store.root}"))
        return self.losses[task] <= MOST_LOSSES

    def establish(self, task: Task, record: Record, how: Kind) -> None:
        before = self.resolver.results.get(task)
        self.resolver.results[task] = record
        self.thinner.add(task, record, before)
        if how == "finished":
            self.counts["evaluated"] += 1
            self.seconds[origin(task.node)] += record.seconds
            self.processor[origin(task.node)] += record.processor or 0.0
            self.compiled[origin(task.node)] += record.compiled or 0.0
        elif before is None:
            self.counts["cached"] += 1
        self.report(Event(how, task, record.seconds, record=record))
        self.limits = self.options.judge.limits(task, record)
        self.report_once(task, record.prepare_warnings, task.node)
        for message in record.warnings if before is None else ():
            self.report(Event("warning", task, message=message))
        if before is not None and before.outputs != record.outputs:
            self.report(Event("warning", task, message=DIFFERS))
        if not self.publish(task, record):
            return
        for waiter in self.waiters.pop(task, ()):
            self.unmet[waiter].discard(task)
            if not self.unmet[waiter]:
                self.agenda.append(waiter)

    def publish_path(self, task: Task) -> Path | None:
        """Where the file of a task is published; None where it is not, or not in this run."""
        return self.graph.nodes[task.node].publish_path(task.frame) if self.portion.publishes(task) else None

    def publish(self, task: Task, record: Record) -> bool:
        """Publish the file of a task; False where its object was damaged and the task is scheduled again."""
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
        """Record a failure. Tasks that wait for it are not woken, except those that take what was reached before."""
        divergence = end_scan(self.resolver, failure.task) if failure.kind == "diverged" else None
        if divergence is not None:
            self.ended |= divergence.lost
            self.store.note(divergence_note(self.keys[failure.task]), failure.message)
            self.report(Event("warning", failure.task, message=f"{failure.message}; frames before are used"))
            for task in divergence.consumers:
                self.unmet[task] -= divergence.lost
                if not self.unmet[task]:
                    self.agenda.append(task)
            return
        self.failures[failure.task] = failure
        self.report(Event("failed", failure.task, message=failure.message, parts=failure.parts))

    def note_latest(self) -> None:
        """Record which results are the latest: a plan is compared with them."""
        keys: dict[str, dict[str, str]] = {}
        for task, record in self.resolver.results.items():
            keys.setdefault(task.node, {})["" if task.frame is None else str(task.frame)] = record.key
        for node, latest in keys.items():
            with suppress(OSError):  # on a full disk the differences are lost, nothing else
                self.store.set_latest(self.graph.name, node, latest)

    def outcome(self, interrupted: bool) -> Outcome:
        reached = self.resolver.results.keys() | self.failures.keys() | self.ended
        return Outcome(
            evaluated=self.counts["evaluated"],
            cached=self.counts["cached"],
            blocked=sum(not is_beyond(task, self.limits) for task in self.portion.asked - reached),
            leased=len(self.elsewhere),
            failures=tuple(self.failures.values()),
            published=tuple(self.published),
            seconds=dict(self.seconds),
            processor=dict(self.processor),
            compiled=dict(self.compiled),
            interrupted=interrupted,
        )


class Queue:
    """Ready tasks by mode, each in the order of frames, so that the inputs of a scan do not fall behind.

    Wide slots take scans, the critical path, then values for the shot; narrow ones take values per frame, and values
    for the shot while no wide one is free. What is judged is on the critical path: were it left behind, stopped frames
    would be simulated.
    """

    def __init__(self, graph: Graph, judged: frozenset[str] = frozenset()) -> None:
        self._mode = {n.name: "scan" if n.name in judged else n.type.mode for n in graph.nodes.values()}
        self._order = order_of(graph)
        self._heaps: dict[str, list[tuple[int, int, Task]]] = {"scan": [], "once": [], "each": []}

    def push(self, task: Task) -> None:
        rank, frame = self._order(task)
        heapq.heappush(self._heaps[self._mode[task.node]], (frame, rank, task))

    def first(self) -> Task | None:
        return next((heap[0][2] for heap in self._heaps.values() if heap), None)

    def take(self, *, wide: bool, wide_is_free: bool) -> Iterator[Task]:
        """Take tasks for a slot, best first, as long as the caller asks for another."""
        modes = ("scan", "once") if wide else ("each",) if wide_is_free else ("each", "once")
        for mode in modes:
            while self._heaps[mode]:
                yield heapq.heappop(self._heaps[mode])[2]
