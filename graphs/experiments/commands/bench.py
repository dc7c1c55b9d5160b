"""`hairpipe bench`: cost of hair and of the engine on this machine."""

from pathlib import Path

import click

from hairpipe.app.cli import options
from hairpipe.app.cli.stderr import echo
from hairpipe.graphs.experiments.bench.commands import bench
from hairpipe.graphs.experiments.bench.machine import share_kernels
from hairpipe.graphs.experiments.commands.measured import moving, print_report, record


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

    A frame is 1/24 s, with all physics. The simulation starts at half a second of the shot, where the head is in full
    motion; times are medians of three frames after a number of settling frames. The last columns are particles and
    seconds in the paper, on one to four machines of four processors. By default all scenes of the paper are measured.
    The inputs of the simulation are kept in the cache.
    """
    share_kernels()  # before kernels are imported
    from hairpipe.app.api.cache import open_store
    from hairpipe.app.api.source import find_graph
    from hairpipe.graphs.experiments.bench.paper import PRINTED, measure_paper

    graphs = {name: find_graph(f"paper/{name}") for name in scenes or PRINTED}
    report = measure_paper(echo, graphs, open_store(cache), overrides, moving, threads)
    print_report(report, as_json, graphs.values())


@bench.command("first-frame")
@click.argument("graph", default="demo")
@options.overrides
@options.as_json
@record
def first_frame(graph: str, overrides: dict[str, str], as_json: bool) -> None:
    """Measure the first frame after an edit: processor seconds of a new worker, by phase.

    GRAPH has a node `hair`. Kernels are compiled before, and the inputs of `hair` are computed in a temporary store.
    """
    from hairpipe.app.api.source import find_graph
    from hairpipe.graphs.experiments.bench.engine.first_frame import measure_first_frame

    path = find_graph(graph)
    print_report(measure_first_frame(path, overrides), as_json, [path])


@bench.command("first-use")
@click.argument("graph", default="demo")
@options.overrides
@options.as_json
def first_use(graph: str, overrides: dict[str, str], as_json: bool) -> None:
    """Measure compilation: processor seconds of the first two frames without and with kernels; kernels by function.

    GRAPH has a node `hair`, whose first step ends at the second frame. Kernels and results are kept in temporary
    folders.
    """
    from hairpipe.app.api.source import find_graph
    from hairpipe.graphs.experiments.bench.engine.first_use import measure_first_use

    print_report(measure_first_use(find_graph(graph), overrides), as_json)


@bench.command()
@click.option("--dask", "with_dask", is_flag=True, help="Dask too, with a scheduler and a worker on this machine.")
@options.jobs
@options.as_json
@record
def engine(with_dask: bool, jobs: int, as_json: bool) -> None:
    """Measure the engine: time per task and per frame of a scan, and memory of the coordinator.

    Toy nodes without work are run in temporary stores, each run in a new process. The time per task is the difference
    between a long and a short shot, a median of five. The last table is a re-run of 240 frames with cached results.

    During --dask, other users of this machine can connect to the scheduler and run code with your rights.
    """
    from hairpipe.graphs.experiments.bench.engine.engine import measure_engine

    print_report(measure_engine(echo, jobs, with_dask=with_dask), as_json)


@bench.command()
@click.argument("graphs", nargs=-1, metavar="[GRAPH]...")
@options.overrides
@options.as_json
@record
def traffic(graphs: tuple[str, ...], overrides: dict[str, str], as_json: bool) -> None:
    """Measure the bytes that a simulation moves through the store, and how many of them a network link carries.

    The node `hair` of each GRAPH (default: demo) is run up to its first checkpoint in a temporary store. A frame writes
    its results, and its state where that is written; it reads its inputs. A link carries both directions at once:

    simulations = bytes a second of the link * seconds a frame / bytes a frame, the larger of written and read

    Seconds a frame are its processor seconds divided by the cores, the least that it can take: other load changes
    neither them nor the bytes.
    """
    from hairpipe.app.api.source import find_graph
    from hairpipe.graphs.experiments.bench.engine.traffic import measure_traffic

    found = {name: find_graph(name) for name in graphs or ("demo",)}
    print_report(measure_traffic(echo, found, overrides), as_json, found.values())
