"""Cost of the engine: time per task, per frame of a scan and of a cached re-run, and memory of the coordinator."""

from contextlib import ExitStack
from statistics import median
from typing import NamedTuple

from hairpipe.graphs.experiments.bench.engine.dask_cluster import dask_cluster
from hairpipe.graphs.experiments.bench.engine.engine_shot import EACH, SCAN, ToyRun, toy_shot
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

Pair = tuple[ToyRun, ToyRun]
"""Runs of a short and a long shot."""


class Sizes(NamedTuple):
    """Numbers of frames of the shots, and of repetitions.

    tasks        frames of a node per frame, of the short and the long shot
    scan_frames  frames of a scan, likewise
    warm         frames of the cached shot
    """

    tasks: tuple[int, int] = (100, 2000)
    scan_frames: tuple[int, int] = (100, 500)
    warm: int = 240
    repeats: int = 5


SIZES = Sizes()


def measure_engine(echo: Echo, jobs: int, *, with_dask: bool = False, sizes: Sizes = SIZES) -> Report:
    """Measure the engine of this machine, and Dask on request; BadInput if Dask does not start.

    jobs  number of narrow workers of each engine
    """
    one_more, memory = list[Case](), list[Case]()
    with ExitStack() as stack:
        schedulers: dict[str, str | None] = {"local": None}
        if with_dask:
            schedulers["dask"] = stack.enter_context(dask_cluster(jobs))
        for engine, scheduler in schedulers.items():
            for what, node, frames in (("task", EACH, sizes.tasks), ("scan frame", SCAN, sizes.scan_frames)):
                echo(f"{engine}: {what}s")
                pairs = [cold_runs(node, frames, jobs, scheduler) for _ in range(sizes.repeats)]
                one_more.append({"engine": engine, "workers": jobs, "one more": what, **difference(pairs)})
                if node == EACH:
                    memory += [{"engine": engine, **coordinator(runs)} for runs in zip(*pairs, strict=True)]
    echo("re-run")
    warm = warm_runs(sizes.warm, jobs, sizes.repeats)
    return make_report(__name__, {"one more": one_more, "coordinator": memory, "re-run": [without_work(warm)]})


def cold_runs(node: str, frames: tuple[int, int], jobs: int, scheduler: str | None) -> Pair:
    """Run a short and a long shot up to a node, each with an empty store."""
    short, long = (cold_run(node, count, jobs, scheduler) for count in frames)
    return short, long


def cold_run(node: str, frames: int, jobs: int, scheduler: str | None) -> ToyRun:
    """Run a shot up to a node with an empty store."""
    with toy_shot(frames) as shot:
        return shot.run((node,), jobs, scheduler)


def warm_runs(frames: int, jobs: int, repeats: int) -> list[ToyRun]:
    """Run a shot, and repeat the cached run."""
    with toy_shot(frames) as shot:
        shot.run((EACH, SCAN), jobs)
        return [shot.run((EACH, SCAN), jobs) for _ in range(repeats)]


def difference(pairs: list[Pair]) -> Case:
    """Return evaluations of a short and a long run, and the time per evaluation [ms]; pure."""
    short, long = pairs[0]
    spent = [1e3 * (b.run - a.run) / (b.evaluated - a.evaluated) for a, b in pairs]
    times = {"median [ms]": median(spent), "minimum [ms]": min(spent), "maximum [ms]": max(spent)}
    return {"from": short.evaluated, "to": long.evaluated, **times}


def coordinator(runs: tuple[ToyRun, ...]) -> Case:
    """Return the time of equal runs, and the peak memory of their coordinators; pure."""
    memory = max((each.memory for each in runs if each.memory is not None), default=None)
    return {"evaluated": runs[0].evaluated, "run [s]": median(each.run for each in runs), "peak memory [MB]": memory}


def without_work(runs: list[ToyRun]) -> Case:
    """Return the time of cached runs; pure."""
    counts = {"cached": runs[0].cached, "evaluated": runs[0].evaluated}
    return {**counts, "run [s]": median(r.run for r in runs), "process [s]": median(r.process for r in runs)}
