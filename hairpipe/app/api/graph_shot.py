"""A checked graph with the cache of its results: plan, run, read.

Stop variants of a wedge: each frame of a measure is compared with the wedge's criteria once it is computed.
"""

import json
import shutil
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from pathlib import Path
from typing import Any, Self

from hairpipe.app.api.reports import Explanation, Plan, Recorder, Run
from hairpipe.app.api.selection import FrameSet, Names, Target, read_frames, read_names, read_target
from hairpipe.app.api.source import Source
from hairpipe.engine.file.bounds import Bounds
from hairpipe.engine.file.graph import Graph, Node
from hairpipe.engine.file.overrides import nodes_of
from hairpipe.engine.file.wedge import Comparison
from hairpipe.engine.hosts.host import Member
from hairpipe.engine.hosts.offer import program_digest
from hairpipe.engine.node.declare import File
from hairpipe.engine.node.messages import nearest
from hairpipe.engine.plan.planner import Planner, read_result, read_value
from hairpipe.engine.plan.planner import explain as explain_task
from hairpipe.engine.plan.tasks import Level, Task, is_beyond, levels_of
from hairpipe.engine.run.events import RECENT, Event, Judge, Options
from hairpipe.engine.run.player import Player, playing_environment
from hairpipe.engine.run.scheduler import run as run_graph
from hairpipe.engine.run.survey import Survey
from hairpipe.engine.store.atomic import keep_mode, replacing
from hairpipe.engine.store.store import Record, Store
from hairpipe.engine.worker.threading_layer import usable_cores
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain
from hairpipe.values import Table

__all__ = ["GraphShot", "Member"]


class Stopping(Judge):
    """Stopped variants, with frame and reason.

    Frames up to the one that fails a criterion are computed: it does not depend on the order of tasks.

    graph     of all variants
    criteria  comparisons of columns of measures with a value per frame
    variants  names of the nodes of every variant in the graph, by their names in the graph file
    """

    def __init__(
        self, graph: Graph, store: Store, criteria: Sequence[Comparison], variants: Mapping[str, Mapping[str, str]]
    ) -> None:
        self._graph, self._store, self._variants = graph, store, variants
        self._criteria: dict[str, list[Comparison]] = {}
        self._users: dict[str, list[str]] = {}
        for variant, names in variants.items():
            for name in names.values():
                self._users.setdefault(name, []).append(variant)
            for criterion in criteria:
                self._criteria.setdefault(names[criterion.node], []).append(criterion)
        self.judged = frozenset(self._criteria)
        self._found: dict[str, tuple[int, str]] = {}
        self._limits: dict[str, int] = {}

    def limits(self, task: Task, record: Record) -> Mapping[str, int]:
        """Check a result; return the frames beyond which nodes are stopped, by name. BadInput for a missing column."""
        for criterion in self._criteria.get(task.node, ()):
            assert task.frame is not None, "checked when the wedge was read"
            why = broken(criterion, read_table(self._graph, self._store, task, record))
            if why is not None:
                self._give_up(task, f"{why} at frame {task.frame}")
        return self._limits

    def gives_up(self, task: Task) -> bool:
        """Whether all variants of a task are stopped, and the task is beyond the last frame of these."""
        return is_beyond(task, self._limits)

    def stopped(self) -> dict[str, str]:
        """Return the reasons for stopped variants, by name, in the order of the wedge."""
        return {variant: self._found[variant][1] for variant in self._variants if variant in self._found}

    def frame_of(self, variant: str) -> int | None:
        """Return the frame at which a variant was stopped; None where it was not."""
        return self._found[variant][0] if variant in self._found else None

    def _give_up(self, task: Task, why: str) -> None:
        """Stop every variant that has a task; shared tasks continue as long as another variant needs them."""
        assert task.frame is not None
        for variant in self._users[task.node]:
            self._found[variant] = min(self._found.get(variant, (task.frame, why)), (task.frame, why))
        for name, users in self._users.items():
            if all(user in self._found for user in users):
                self._limits[name] = max(self._found[user][0] for user in users)


def read_table(graph: Graph, store: Store, task: Task, record: Record) -> Table:
    """Read a result that is a table; BadInput for any other."""
    value = read_value(graph, store, task, record)
    if not isinstance(value, Table):
        raise BadInput(f"'{task}' is not a table", where=graph.path, right="a node with a Table as output")
    return value


def broken(criterion: Comparison, table: Table) -> str | None:
    """Compare a column of a table; return the worst value that stops a variant in words, None without one."""
    if criterion.column not in table.numbers:
        what = f"stop: '{criterion.node}' has no column"
        right = nearest(criterion.column, list(table.numbers))
        raise BadInput(f"{what} '{criterion.column}'", right=right)
    values = table.numbers[criterion.column]
    worst = values[criterion.holds(values, criterion.right)]
    if not len(worst):
        return None
    value = min(worst) if criterion.relation.startswith("<") else max(worst)
    return f"{criterion.left} {value:.4g} {criterion.relation} {json.dumps(criterion.right)}"


class GraphShot:
    """A checked graph with the cache of its results; the base of `Shot` and `WedgeShot`.

    It does not change: `changed` makes another one.

    graph  graph of the engine
    """

    def __init__(self, source: Source, store: Store, spare: list[Member] | None = None) -> None:
        self._source, self._store, self._spare = source, store, spare
        self.graph: Graph = source.graph()

    def __repr__(self) -> str:
        return repr(self.graph).replace("<Graph", "<Shot", 1)

    @property
    def path(self) -> Path:
        """The graph file."""
        return self.graph.path

    @property
    def cache(self) -> Path:
        """Folder of results."""
        return self._store.root

    @property
    def program(self) -> str:
        """Digest of all code that a new process could import for this graph, by its stamps."""
        return program_digest(self.graph.folder)

    @property
    def frames(self) -> range:
        """Frames of the shot."""
        return self.graph.all_frames

    @property
    def fps(self) -> float:
        """Frames per second [1/s]."""
        return self.graph.fps

    @property
    def nodes(self) -> dict[str, Node]:
        """Nodes by name, each after those it depends on; `nodes["hair"].type.outputs` names its outputs."""
        return dict(self.graph.nodes)

    @property
    def tables(self) -> dict[str, Any]:
        """A copy of the tables of the graph file, with `like` expanded and changed settings."""
        return self._source.tables

    def changed(self, set: Mapping[str, Any]) -> Self:
        """Return the shot with settings changed, by `node.setting` or `node.group.setting`; pure."""
        return self._of(self._source.changed(set)) if set else self

    def edited(self, tables: Mapping[str, Any]) -> Self:
        """Return a shot of the same file with other tables; pure."""
        return self._of(self._source.edited(tables))

    def unpublished(self) -> Self:
        """Return the shot without published files; pure."""
        tables = self.tables
        for table in nodes_of(tables).values():
            table.pop("publish", None)
        return self.edited(tables)

    def part(self, to: Names) -> Graph:
        """Return the graph, or the part of it up to some nodes; BadInput for an unknown one."""
        names = read_names(to)
        return self.graph.upto(names) if names else self.graph

    def levels(self) -> list[Level]:
        """List the groups of nodes that can be computed one after another, each divided among machines."""
        return levels_of(self.graph)

    def stopping(self) -> Stopping:
        """Return the criteria that stop variants during a run; None for a shot of one variant."""
        return Stopping(self.graph, self._store, (), {})

    def plan(
        self,
        frames: FrameSet = None,
        *,
        to: Names = (),
        set: Mapping[str, Any] | None = None,
        publish_root: Path | None = None,
    ) -> Plan:
        """Report the computation of `run`, with reasons, without computing or writing. BadInput as of `run`."""
        shot = self.changed(set or {})
        graph = shot.part(to)
        Bounds(graph, self.cache, publish_root).check()
        planner = Planner(graph, self._store, read_frames(frames))
        stopping = shot.stopping()
        entries = planner.entries()
        results = planner.resolver.results
        known = {entry.task: results[entry.task] for entry in entries if entry.status == "cached"}
        for task, record in known.items():
            stopping.limits(task, record)
        return Plan(tuple(e for e in entries if not stopping.gives_up(e.task)), known, stopping.stopped())

    def costs(self, nodes: Iterable[str]) -> dict[str, float]:
        """Return what the latest results of nodes took, a median, whatever their settings were; by node [s]."""
        found = {}
        for name in nodes:
            keys = [*self._store.latest(self.graph.name, name).values()][-RECENT:]
            seconds = [record.seconds for key in keys if (record := self._store.record(key))]
            found |= {name: statistics.median(seconds)} if seconds else {}
        return found

    def survey(self, frames: FrameSet = None, *, to: Names = ()) -> Survey:
        """Read which results exist and which are computed now, by any process that shares the cache; see `Survey`."""
        return Survey(self.part(to), self._store, read_frames(frames), self.stopping())

    def run(
        self,
        frames: FrameSet = None,
        *,
        to: Names = (),
        set: Mapping[str, Any] | None = None,
        jobs: int | None = None,
        progress: Callable[[Event], object] | None = None,
        keep_going: bool = False,
        publish_root: Path | None = None,
        force: bool = False,
        only: FrameSet = None,
        wait: float | None = None,
        scheduler: str | None = None,
        insecure: bool = False,
        scans: int = 1,
    ) -> Run:
        """Compute what has changed, and publish; BadInput before computing. A node that fails is reported.

        frames        such as "1001-1060x2", 1001, or range(1001, 1061); all frames by default. Frames before them are
                      computed where a simulation needs them
        to            only these nodes and their dependencies
        set           settings to change for this run; the report's `shot` has them
        jobs          processes, and threads of a simulation; all cores by default. Results do not depend on it
        progress      called with every event, such as `print`
        keep_going    after a failure, continue with independent nodes
        publish_root  folder below which files may be published in addition to that of the project
        force         overwrite files that hairpipe has not published, or that were changed since
        only          frames to compute, of a shot of `frames`; what sees all of these is computed if they are there
        scheduler     address of a Dask scheduler whose workers compute, `tls://` unless `insecure`
        scans         simulations at a time on this machine, which share the threads; a Dask worker has one at a time
        wait          time for which the run waits for what only other processes compute [s]; by default without end
        """
        shot = self.changed(set or {})
        graph = shot.part(to)
        stopping = shot.stopping()
        numbers = graph.select(read_frames(frames))
        options = Options(
            jobs or usable_cores(),
            keep_going,
            publish_root=publish_root,
            force=force,
            only=read_frames(only),
            wait=wait,
            scheduler=scheduler,
            insecure=insecure,
            judge=stopping,
            spare=self._spare,
            scans=scans,
        )
        self._make_cache()
        begun = time.monotonic()
        recorder = Recorder(graph, options.jobs, progress)
        outcome = run_graph(graph, self._store, numbers, options, recorder)
        seconds = time.monotonic() - begun
        found = recorder.progress.nodes, recorder.warnings, recorder.statuses, seconds, stopping.stopped()
        return Run(shot, graph, numbers, outcome, *found)

    @contextmanager
    def keeping_workers(self) -> Iterator[Self]:
        """Yield the shot with workers that are kept between its runs, and those of shots made of it.

        Within another such block the workers are those of the outer one, and are kept until its end.
        """
        if self._spare is not None:
            yield self
            return
        spare = list[Member]()
        try:
            yield self.with_workers(spare)
        finally:
            for member in spare:
                member.end()

    def with_workers(self, spare: list[Member]) -> Self:
        """Return the shot with idle workers, which its runs take from this list and return to it."""
        kept = copy(self)
        kept._spare = spare
        return kept

    def get(self, target: str | Target, *, frames: FrameSet = None) -> Any:
        """Read a result from the cache; BadInput where it has not been computed.

        target  `hair.strands@1020`: output `strands` of `hair` at frame 1020; `hair@1020`: its first output; `groom`:
                value for the shot. `hair`, of a node with a value per frame: values by frame
        frames  frames of the run, for a result that depends on them; for values by frame, the frames to read
        """
        node, output, frame = read_target(target) if isinstance(target, str) else target
        numbers = read_frames(frames)
        if frame is not None or not self.graph.node(node).per_frame:
            return read_result(self.graph, self._store, Task(node, frame), output, numbers)
        found = self.results(numbers, to=node)
        tasks = [Task(node, number) for number in self.graph.select(numbers)]
        return {task.frame: read_value(self.graph, self._store, task, found.get(str(task)), output) for task in tasks}

    def write(self, target: str | Target, output: Path, *, frames: FrameSet = None) -> None:
        """Write a result to a file, in the format of its suffix; a result that is a file is copied with its companions.

        BadInput as for `get`, and for a format that does not hold the value. `target` and `frames` are those of `get`.
        """
        from hairpipe.formats.values import write_value

        target = self.single(read_target(target) if isinstance(target, str) else target)
        value = self.get(target, frames=frames)
        if output.is_dir():
            raise BadInput("is a folder", where=output, right="the name of a file")
        check_plain(output, "the name of a file")
        if isinstance(value, File):
            names = {output: value.path} | {output.parent / name: path for name, path in value.companions.items()}
            for copied, source in names.items():
                with replacing(copied) as temporary:
                    shutil.copyfile(source, temporary)
                    keep_mode(temporary, copied)
        else:
            write_value(output, value, self.graph.frames[0] if target.frame is None else target.frame, self.fps)

    def read(self, task: Task, record: Record | None, output: str | None = None) -> Any:
        """Read an output of a result by its record, see `plan`; BadInput for a missing result or output."""
        return read_value(self.graph, self._store, task, record, output)

    def object_path(self, name: str) -> Path:
        """Path of an object of a result in the cache, complete or not; ValueError for an invalid name."""
        return self._store.object_path(name)

    def player(self, node: str) -> Player:
        """Play the simulations before a node in this process, see `Player`; BadInput where this is impossible."""
        return Player(self.graph, self._store, node)

    def playing_environment(self) -> dict[str, str]:
        """Environment of a process that calls `player`; BadInput or OSError without a safe folder for kernels."""
        return playing_environment(self.graph, self._store)

    def single(self, target: Target) -> Target:
        """Return a target that names one result; BadInput where a frame is missing."""
        if target.frame is None and self.graph.node(target.node).per_frame:
            right = f"{target.node}@{self.graph.frames[0]}"
            raise BadInput(f"'{target.node}' has a value per frame", where=self.path, right=right)
        return target

    def results(self, frames: FrameSet = None, *, to: Names = ()) -> dict[str, Record]:
        """Return the records of all cached results, by target: inputs, time and duration of computation."""
        planner = Planner(self.part(to), self._store, read_frames(frames))
        known = [entry.task for entry in planner.entries() if entry.status == "cached"]
        return {str(task): planner.resolver.results[task] for task in known}

    def explain(self, target: str | Target, *, frames: FrameSet = None) -> Explanation:
        """Report the inputs of a result, and every difference to the latest one; BadInput for an unknown target."""
        node, output, frame = read_target(target) if isinstance(target, str) else target
        self.graph.output(node, output)
        return Explanation(**vars(explain_task(self.graph, self._store, Task(node, frame), read_frames(frames))))

    def _of(self, source: Source) -> Self:
        return type(self)(source, self._store, self._spare)

    def _make_cache(self) -> None:
        try:
            self.cache.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInput(f"cannot be made: {error.strerror}", where=self.cache, right="a folder") from None
