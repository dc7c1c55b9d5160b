"""`hairpipe bench`: what hair, and the engine, cost on this machine."""

from pathlib import Path

import click

from hairpipe.cli import options
from hairpipe.cli.measured import moving, print_report, record
from hairpipe.cli.stderr import echo


@click.group()
def bench() -> None:
    """Measure what hair, and the engine, cost on this machine."""


@bench.command()
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@moving(default=(5,), multiple=True, help="Number of frames before the measured ones; repeatable.")
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    multiple=True,
    help="Number of threads to measure with; by default all cores; repeatable.",
)
@options.overrides
@options.cache
@options.as_json
@record
def paper(
    scenes: tuple[str, ...],
    moving: tuple[int, ...],
    threads: tuple[int, ...],
    overrides: dict[str, str],
    cache: Path,
    as_json: bool,
) -> None:
    """Reproduce Table 2 of Selle, Lentine, Fedkiw 2008: seconds a frame of the scenes in graphs/paper.

    A frame is 1/24 s, all physics is on. The simulation starts at half a second of the shot, where the head is in full
    motion; medians over the three frames after those that let it move.
    Last come particles and seconds of the paper, on one to four machines of four processors. Without a SCENE, those of
    the paper. The inputs of the simulation are kept in the cache.
    """
    from hairpipe.bench.machine import share_kernels

    share_kernels()  # before kernels are imported
    from hairpipe.api.cache import open_store
    from hairpipe.api.source import find_graph
    from hairpipe.bench.paper import PRINTED, measure_paper

    graphs = {name: find_graph(f"paper/{name}") for name in scenes or PRINTED}
    report = measure_paper(echo, graphs, open_store(cache), overrides, moving, threads)
    print_report(report, as_json, graphs.values())


@bench.command("first-frame")
@click.argument("graph", default="demo")
@options.overrides
@options.as_json
def first_frame(graph: str, overrides: dict[str, str], as_json: bool) -> None:
    """Measure where the time of the first frame after an edit goes: processor seconds of a new worker, by phase.

    GRAPH has a node `hair`. Kernels are compiled before, and what hair depends on is computed, in a temporary store.
    """
    from hairpipe.api.source import find_graph
    from hairpipe.bench.first_frame import measure_first_frame

    print_report(measure_first_frame(find_graph(graph), overrides), as_json)


@bench.command("first-use")
@click.argument("graph", default="demo")
@options.overrides
@options.as_json
def first_use(graph: str, overrides: dict[str, str], as_json: bool) -> None:
    """Measure compilation: processor seconds of the first two frames without and with kernels; kernels by function.

    GRAPH has a node `hair`, whose first step leads to the second frame. Kernels and results are kept in temporary
    folders.
    """
    from hairpipe.api.source import find_graph
    from hairpipe.bench.first_use import measure_first_use

    print_report(measure_first_use(find_graph(graph), overrides), as_json)


@bench.command()
@click.option("--dask", "with_dask", is_flag=True, help="Dask too, with a scheduler and a worker on this machine.")
@options.jobs
@options.as_json
@record
def engine(with_dask: bool, jobs: int, as_json: bool) -> None:
    """Measure the engine: time of one more task and one more frame of a scan, and memory of the coordinator.

    Toy nodes without work are run in temporary stores, each run in a process of its own. The time of one more is the
    difference between a long and a short shot, medians of five. Last comes a re-run of 240 frames that finds all
    results cached.

    While --dask measures, users of this machine can reach the scheduler and run code as you.
    """
    from hairpipe.bench.engine import measure_engine

    print_report(measure_engine(echo, jobs, with_dask=with_dask), as_json)
