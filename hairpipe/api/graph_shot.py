"""A checked graph with the cache of its results: plan, run, read."""

import os
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from pathlib import Path
from typing import Any, Self

from hairpipe.api.explanation import Explanation
from hairpipe.api.reports import Plan, Recorder, Run
from hairpipe.api.selection import FrameSet, Names, Target, read_frames, read_names, read_target
from hairpipe.api.source import Source
from hairpipe.api.stopping import Stopping
from hairpipe.errors import BadInput
from hairpipe.graph.engine.kept_workers import kept_workers
from hairpipe.graph.engine.member import Member
from hairpipe.graph.engine.program import program_digest
from hairpipe.graph.file.bounds import Bounds
from hairpipe.graph.file.graph import Graph, Node
from hairpipe.graph.plan.levels import Level, levels_of
from hairpipe.graph.plan.planner import Planner
from hairpipe.graph.plan.planner import explain as explain_task
from hairpipe.graph.plan.tasks import Task
from hairpipe.graph.results import read_result, read_value
from hairpipe.graph.run.events import RECENT, Event, Options
from hairpipe.graph.run.player import Player, playing_environment
from hairpipe.graph.run.scheduler import run as run_graph
from hairpipe.graph.run.survey import Survey
from hairpipe.graph.store.record import Record
from hairpipe.graph.store.store import Store

__all__ = ["GraphShot", "Member"]


class GraphShot:
    """A checked graph with the cache of its results; the base of `Shot` and `WedgeShot`.

    It does not change: `changed` makes another one.

    graph  graph of the engine
    """

    _outlives = False

    def __init__(self, source: Source, store: Store, spare: list[Member] | None = None) -> None:
        self._source, self._store, self._spare = source, store, spare
        self.graph: Graph = source.graph()

    def __repr__(self) -> str:
        """Write path, number of nodes, and frames."""
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
            jobs or os.cpu_count() or 1,
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
            outlives=self._outlives,
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

    def with_workers(self, spare: list[Member], *, outlives: bool = False) -> Self:
        """Return the shot with idle workers, which its runs take from this list and return to it.

        outlives  whether they may outlive this process: what their nodes print is discarded then
        """
        kept = copy(self)
        kept._spare, kept._outlives = spare, outlives
        return kept

    @contextmanager
    def sharing_workers(self) -> Iterator[Self]:
        """Yield the shot with idle workers of earlier processes; those of its runs are kept for later ones."""
        with kept_workers(self.graph.folder) as spare:
            yield self.with_workers(spare, outlives=True)

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
