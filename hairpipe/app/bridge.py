"""Protocol of JSON lines by which another program plans, runs and reads graphs: `docs/reference/bridge.md`.

A thread reads requests, and the main thread handles them in their order. A signal interrupts the run that is cancelled.
"""

import json
import os
import platform
import queue
import signal
import sys
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from math import ceil, inf
from pathlib import Path
from types import FrameType
from typing import Any, BinaryIO, NamedTuple

from hairpipe import __version__
from hairpipe.app.api.draft import load_draft, write_tables
from hairpipe.app.api.graph_shot import GraphShot, Member
from hairpipe.app.api.node_types import document, node_types
from hairpipe.app.api.reports import STATUSES, Event, Graph, NodeProgress, Progress, Run, Task, fault_document, origin
from hairpipe.app.api.selection import fold_frames
from hairpipe.app.api.shot import load
from hairpipe.engine.file.overrides import parse_value
from hairpipe.engine.node.messages import brief, nearest
from hairpipe.engine.store.atomic import open_made, replacing
from hairpipe.engine.worker.threading_layer import usable_cores
from hairpipe.errors import BadInput
from hairpipe.values import Strands

PROTOCOL = 1
MOST_BYTES = 16 << 20
"""Maximum length of a request [bytes]."""
CHUNK = 1 << 16
"""Number of bytes that are read at a time."""
MOST_JOBS = 1024
INTERVAL = 0.05
"""Smallest interval of two lines about the progress of a run [s]."""
IDLE = 600.0
"""Time without a request after which idle workers end [s]."""
INTERRUPTED = 130
"""Exit code of a cancelled run."""

Id = int | float | str
Fields = dict[str, Any]


class Kind(NamedTuple):
    """A kind of value that a field of a request holds."""

    right: str
    holds: Callable[[Any], bool]


def is_id(value: Any) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < inf
    return is_number or isinstance(value, str)


ID = Kind("a number or a text", is_id)
TEXT = Kind("a text", lambda value: isinstance(value, str))
GRAPH = Kind("a text without a line break", lambda value: isinstance(value, str) and "\n" not in value)
FLAG = Kind("true or false", lambda value: isinstance(value, bool))
JOBS = Kind(f"a whole number, 1 to {MOST_JOBS}", lambda value: type(value) is int and 1 <= value <= MOST_JOBS)
NAMES = Kind("a list of texts", lambda value: isinstance(value, list) and all(isinstance(one, str) for one in value))
TABLE = Kind("an object", lambda value: isinstance(value, dict))
TEXTS = Kind("an object of texts", lambda value: isinstance(value, dict) and NAMES.holds([*value.values()]))
TABLES = Kind("an object of objects", lambda value: TABLE.holds(value) and all(map(TABLE.holds, value.values())))

SHOT = {"graph": GRAPH, "text": TEXT, "set": TEXTS, "cache": TEXT, "frames": TEXT}
PART = SHOT | {"wedge": TEXT, "to": NAMES, "publish": FLAG, "publish_root": TEXT}
REQUESTS = {
    "describe": {"types": NAMES},
    "write": {"graph": GRAPH, "head": TABLE, "tables": TABLES, "owned": NAMES},
    "plan": PART,
    "run": PART | {"jobs": JOBS, "force": FLAG, "keep_going": FLAG, "tasks": FLAG, "live": TEXTS},
    "get": SHOT | {"value": TEXT, "output": TEXT},
    "cancel": {"run": ID},
}
"""Fields of each request, besides `id` and `do`."""
REQUIRED = frozenset({"types", "graph", "tables", "value", "output", "run"})


class Request(NamedTuple):
    """A request that has been checked."""

    id: Id
    do: str
    fields: Fields


def read_lines(descriptor: int) -> Iterator[bytes]:
    """Read the lines of a file or pipe; of a line that is too long only the beginning is kept.

    A stream of Python would have a lock, which the end of the process waits for while a thread reads.
    """
    kept = bytearray()
    while chunk := os.read(descriptor, CHUNK):
        *lines, last = chunk.split(b"\n")
        for line in lines:
            yield bytes(kept + line)
            kept.clear()
        if len(kept) <= MOST_BYTES:
            kept += last
    if kept:
        yield bytes(kept)


def read_object(line: bytes) -> Fields:
    """Read a line as a JSON object; BadInput for anything else."""
    if len(line) > MOST_BYTES:
        raise BadInput("the line is too long", right=f"at most {MOST_BYTES} bytes")
    try:
        found = json.loads(line.decode("utf-8").strip(), parse_constant=refuse_constant)
    except (ValueError, RecursionError) as error:
        raise BadInput(f"the line is not JSON: {error}", right="a JSON object on one line, in UTF-8") from None
    if not isinstance(found, dict):
        raise BadInput("the line is not a JSON object", right='{"id": 1, "do": "plan", "graph": "shot.toml"}')
    return found


def refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not a number of JSON")


def check_request(given: Fields) -> Request:
    """Check the fields of a request; BadInput for the first that is unknown, missing or of another kind."""
    do = given.get("do")
    if not isinstance(do, str) or do not in REQUESTS:
        right = nearest(do, list(REQUESTS)) if isinstance(do, str) else f"one of {', '.join(REQUESTS)}"
        raise BadInput(f"do = {brief(do)} is not a request", right=right)
    kinds = {"id": ID, "do": TEXT} | REQUESTS[do]
    for name, value in given.items():
        if name not in kinds:
            raise BadInput(f"{do} has no field '{name[:60]}'", right=nearest(name, list(kinds)))
        if not kinds[name].holds(value):
            raise BadInput(f"{name} = {brief(value)}", right=kinds[name].right)
    for name, kind in kinds.items():
        if name not in given and (name == "id" or name in REQUIRED):
            raise BadInput(f"{do} lacks the field '{name}'", right=kind.right)
    return Request(given["id"], do, {name: value for name, value in given.items() if name not in ("id", "do")})


def load_shot(fields: Fields) -> GraphShot:
    """Load the shot of a request: a text in place of that of the file may be incomplete."""
    graph = fields["graph"]
    cache = fields.get("cache")
    settings = {target: parse_value(literal) for target, literal in fields.get("set", {}).items()}
    if "text" in fields:
        shot = load_draft(graph, fields["text"], cache=cache).shot.changed(settings)
    else:
        shot = load(graph, settings, cache=cache)
    shot = shot if fields.get("publish", True) else shot.unpublished()
    return shot.wedge(fields["wedge"]) if "wedge" in fields else shot


def expected_seconds(nodes: Mapping[str, NodeProgress], costs: Mapping[str, float]) -> float | None:
    """Return the time that the rest of all nodes takes, one after another [s]; None where that of one is unknown.

    costs  what a result takes by node, where none has been computed yet [s]
    """
    total = 0.0
    for name, node in nodes.items():
        left = node.total - node.done
        rate = costs.get(name) if node.seconds_per_frame is None else node.seconds_per_frame
        if left and rate is None:
            return None
        total += (rate or 0.0) * ceil(left / node.width)
    return round(total, 3)


Send = Callable[..., None]


class RunReport:
    """Writes the events of a run; the latest progress is written by a thread, at most once in an interval.

    shot    shot that is run
    fields  fields of the request
    jobs    number of processes of the run
    send    function that writes an event
    """

    def __init__(self, shot: GraphShot, fields: Fields, jobs: int, send: Send) -> None:
        self._shot, self._send = shot, send
        self._names_tasks = fields.get("tasks", False)
        graph = shot.part(fields.get("to", ()))
        self._live = {name: Path(folder) for name, folder in fields.get("live", {}).items()}
        self._outputs = {name: hair_output(graph, name) for name in self._live}
        self._costs = shot.costs(graph.nodes)
        self._known: set[Task] = set()
        self._progress = Progress(graph, jobs)
        self._latest: dict[str, Any] | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._sample, daemon=True)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of results that were computed, and that were cached."""
        nodes = self._progress.nodes.values()
        return {"computed": sum(node.evaluated for node in nodes), "cached": sum(node.cached for node in nodes)}

    @contextmanager
    def sampled(self) -> Iterator[None]:
        """Write the progress while the run goes on."""
        self._thread.start()
        try:
            yield
        finally:
            self._ended.set()
            self._thread.join()

    def _sample(self) -> None:
        written = None
        while True:
            ended = self._ended.wait(INTERVAL)
            latest = self._latest
            if latest is not None and latest is not written:
                self._send("progress", **latest)
                written = latest
            if ended:
                return

    def __call__(self, event: Event) -> None:
        """Write an event of the run, or keep it as the latest progress."""
        self._progress.update(event)
        nodes = self._progress.nodes
        if self._names_tasks and event.task is not None and event.kind in STATUSES:
            self._send("task", **event.task._asdict(), status=STATUSES[event.kind])
        if event.kind == "begun":
            self._send("begun", totals=dict(event.totals))
        elif event.kind == "published":
            self._send("published", path=event.message)
        elif event.task is not None and event.kind == "warning":
            self._send("warning", **event.task._asdict(), message=event.message)
        elif event.task is not None and event.kind == "failed":
            parts = {"what": event.message, "where": None, "right": None, **event.parts}
            self._send("failed", **event.task._asdict(), **parts)
        elif event.task is not None and event.kind in ("cached", "finished"):
            self._latest = {
                "done": sum(node.done for node in nodes.values()),
                "total": sum(node.total for node in nodes.values()),
                "seconds_left": expected_seconds(nodes, self._costs),
                **event.task._asdict(),
                "cached": event.kind == "cached",
            }
            if event.task.node in self._live and event.task not in self._known:
                self._known.add(event.task)
                self._write_frame(event)

    def _write_frame(self, event: Event) -> None:
        """Write the points of hair at a frame; what fails is a warning, since the result is in the store."""
        assert event.task is not None
        node, frame = event.task
        path = self._live[node].absolute() / f"{node}.{frame}.f32"
        try:
            hair: Strands = self._shot.read(event.task, event.record, self._outputs[node])
            with replacing(path, lasting=False) as temporary, open_made(temporary) as file:
                file.write(hair.points.astype("<f4").tobytes())
        except (BadInput, OSError) as fault:
            self._send("warning", node=node, frame=frame, message=f"{path} cannot be written: {fault}")
        else:
            counts = {"strands": len(hair.offsets) - 1, "points": len(hair.points)}
            self._send("frame", node=node, frame=frame, file=str(path), **counts)


def hair_output(graph: Graph, name: str) -> str:
    """Return the output of a node that is hair per frame; BadInput for a node without one."""
    node = graph.node(name)
    found = [output for output, kind in node.type.outputs.items() if kind is Strands]
    if not found or not node.per_frame:
        raise BadInput(f"'{name}' has no hair per frame", where="live", right="a node whose output is Strands")
    return found[0]


class Bridge:
    """Handles the requests of one program until their end; `serve` runs in the main thread."""

    def __init__(self, requests: Iterable[bytes], events: BinaryIO) -> None:
        self._requests, self._events = requests, events
        self._lock = threading.RLock()  # a signal comes while it is held
        self._queue: queue.SimpleQueue[Request | None] = queue.SimpleQueue()
        self._spare: list[Member] = []
        self._runs: set[Id] = set()  # runs that wait, and the active one
        self._cancelled: set[Id] = set()
        self._active: Id | None = None
        self._may_stop = False  # whether the main thread is in a run, and not in a report of it
        self._handlers: dict[str, Callable[[Request], Fields]] = {
            "describe": self._describe,
            "write": self._write,
            "plan": self._plan,
            "run": self._run,
            "get": self._get,
        }

    def serve(self) -> None:
        """Handle requests until their end; a run that is in progress then is cancelled."""
        before = {number: signal.signal(number, self._interrupt) for number in (signal.SIGINT, signal.SIGUSR1)}
        try:
            self._send("hello", protocol=PROTOCOL, hairpipe=__version__, python=platform.python_version())
            threading.Thread(target=self._read, daemon=True).start()
            while (request := self._next()) is not None:
                self._handle(request)
        finally:
            self._end_workers()
            for number, handler in before.items():
                signal.signal(number, handler)

    def _next(self) -> Request | None:
        try:
            return self._queue.get(timeout=IDLE)
        except queue.Empty:
            self._end_workers()
            return self._queue.get()

    def _end_workers(self) -> None:
        while self._spare:
            self._spare.pop().end()

    def _send(self, event: str, **fields: Any) -> None:
        line = json.dumps({"event": event, **fields}).encode() + b"\n"
        with self._lock:
            try:
                self._events.write(line)
                self._events.flush()
            except (OSError, ValueError):  # the reader has ended
                self._end()

    def _fail(self, request: Id | None, fault: Exception) -> None:
        """Answer with an error; a fault that is not of the request is also written to the standard error stream."""
        if isinstance(fault, OSError):
            fault = BadInput(fault.strerror or str(fault), where=fault.filename)
        if not isinstance(fault, BadInput):
            traceback.print_exception(fault, file=sys.stderr)
            fault = BadInput(f"{type(fault).__name__}: {fault}")
        self._send("error", id=request, **fault_document(fault))

    def _read(self) -> None:
        for line in self._requests:
            self._accept(line)
        self._end()

    def _accept(self, line: bytes) -> None:
        """Check a request and let it wait, or cancel a run at once."""
        known = None
        try:
            given = read_object(line)
            known = given["id"] if is_id(given.get("id")) else None
            request = check_request(given)
            if request.do == "cancel":
                self._cancel(request.fields["run"])
                self._send("done", id=known)
                return
            if request.do == "run":
                with self._lock:
                    if request.id in self._runs:
                        raise BadInput(f"a run {json.dumps(known)} is in progress", right="an id of its own")
                    self._runs.add(request.id)
            self._queue.put(request)
        except Exception as fault:  # reading goes on whatever a request has met
            self._fail(known, fault)

    def _cancel(self, run: Id) -> None:
        with self._lock:
            if run not in self._runs:
                raise BadInput(f"no run {json.dumps(run)} is in progress", right="the id of a run without `done`")
            self._stop({run})

    def _end(self) -> None:
        """Cancel all runs, and end after the other requests; the signal may interrupt this function."""
        self._queue.put(None)
        with self._lock:
            self._stop(self._runs)

    def _stop(self, runs: Collection[Id]) -> None:
        self._cancelled |= set(runs)
        if self._active in self._cancelled:
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGUSR1)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        """Interrupt the run that is cancelled; Ctrl-C ends the bridge as the end of the requests does."""
        if number == signal.SIGINT:
            self._end()
        if self._may_stop and self._active in self._cancelled:
            self._may_stop = False
            raise KeyboardInterrupt

    def _handle(self, request: Request) -> None:
        try:
            self._send("done", id=request.id, **self._handlers[request.do](request))
        except Exception as fault:  # the next request is handled whatever this one has met
            self._fail(request.id, fault)

    def _describe(self, request: Request) -> Fields:
        catalogue = node_types(experiments=True)
        return {"types": {name: document(catalogue.find(name)) for name in request.fields["types"]}}

    def _write(self, request: Request) -> Fields:
        fields = request.fields
        path = Path(fields["graph"])
        return {"changed": write_tables(path, fields.get("head", {}), fields["tables"], fields.get("owned", ()))}

    def _plan(self, request: Request) -> Fields:
        fields = request.fields
        shot = load_shot(fields)
        root = fields.get("publish_root")
        found = shot.plan(fields.get("frames"), to=fields.get("to", ()), publish_root=root and Path(root))
        frames: dict[str, list[int]] = {}
        for entry in found.missing:
            if entry.task.frame is not None:
                frames.setdefault(origin(entry.task.node), []).append(entry.task.frame)
        counts = Counter(origin(entry.task.node) for entry in found.missing)
        progress = Progress(shot.graph, usable_cores())
        progress.update(Event("begun", totals=tuple(counts.items())))
        return found.document() | {
            "to_run": dict(counts),
            "frames_to_run": {node: fold_frames(numbers) for node, numbers in frames.items()},
            "seconds": expected_seconds(progress.nodes, shot.costs(counts)),
        }

    def _run(self, request: Request) -> Fields:
        begun = time.monotonic()
        fields = request.fields
        jobs = fields.get("jobs") or usable_cores()
        root = fields.get("publish_root")
        try:
            shot = load_shot(fields).with_workers(self._spare)
            report = RunReport(shot, fields, jobs, lambda event, **found: self._send(event, id=request.id, **found))

            def run() -> Run:
                return shot.run(
                    fields.get("frames"),
                    to=fields.get("to", ()),
                    jobs=jobs,
                    keep_going=fields.get("keep_going", False),
                    publish_root=root and Path(root),
                    force=fields.get("force", False),
                    progress=lambda event: self._report(report, event),
                )

            with report.sampled():
                done = self._interruptible(request.id, run)
        finally:
            with self._lock:
                self._runs.discard(request.id)
                self._cancelled.discard(request.id)
        code = INTERRUPTED if done is None else done.outcome.exit_code
        return {"exit_code": code, **report.counts, "seconds": round(time.monotonic() - begun, 3)}

    def _interruptible(self, request: Id, run: Callable[[], Run]) -> Run | None:
        """Return what a run returns; None for one that is cancelled before or after its computation."""
        try:
            self._active = request
            self._may_stop = True
            return None if request in self._cancelled else run()
        except KeyboardInterrupt:
            return None
        finally:
            self._may_stop = False
            self._active = None

    def _report(self, report: RunReport, event: Event) -> None:
        """Report an event of the active run, and interrupt it afterwards if it was cancelled meanwhile."""
        self._may_stop = False
        report(event)
        self._may_stop = True
        if self._active in self._cancelled:
            self._may_stop = False
            raise KeyboardInterrupt

    def _get(self, request: Request) -> Fields:
        output = Path(request.fields["output"])
        load_shot(request.fields).write(request.fields["value"], output, frames=request.fields.get("frames"))
        return {"path": str(output.absolute()), "bytes": output.stat().st_size}


def main() -> None:
    """Serve the program that has started this process, on its standard streams.

    Whatever libraries print on the standard output goes to the standard error stream.
    """
    events = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with suppress(BrokenPipeError), events:
        Bridge(read_lines(0), events).serve()
