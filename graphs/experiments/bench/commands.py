"""`hairpipe bench`, or `python -m hairpipe.graphs.experiments.bench`: cost of hair and of the engine."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.app.cli import options
from hairpipe.app.cli.entry import Group
from hairpipe.app.cli.stderr import echo
from hairpipe.graphs.experiments.bench.calls.call_commands import calls, schedules
from hairpipe.graphs.experiments.bench.machine import share_kernels
from hairpipe.graphs.experiments.bench.machines.machine_commands import machines, parity
from hairpipe.graphs.experiments.bench.mutation.mutation_commands import mutate
from hairpipe.graphs.experiments.bench.scene_commands import PROGRAM, needs, promises
from hairpipe.graphs.experiments.commands.measured import moving, print_report, record

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.bench.head import Between

__all__ = ["PROGRAM", "bench"]


@click.group(cls=Group)
def bench() -> None:
    """Measure the cost of hair and of the engine on this machine."""


for other in (promises, needs, machines, parity, calls, schedules, mutate):
    bench.add_command(other)


@bench.command()
@options.as_json
@record
def core(as_json: bool) -> None:
    """Measure the strand core: time per particle of a solve and of a step, for every model of a strand.

    A solve is one linearly implicit stage: forces, choice of altitude springs, assembly, factorisation and
    substitution. For comparison, measured in the same minutes: the peak arithmetic rate and memory bandwidth of
    the machine, the lower bound they set for a solve, and the time of a prototype. Medians, with the middle half of
    all runs.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.core import measure_core

    print_report(measure_core(echo), as_json)  # lines: whatever moves on the screen would be measured, too


@bench.command()
@click.option(
    "--segments",
    type=click.IntRange(min=100),
    multiple=True,
    help="Total number of segments; by default 1e4, 1e5 and 1e6; repeatable.",
)
@click.option(
    "--between",
    type=click.Choice(["pairs", "locks", "volume", "nothing"]),
    multiple=True,
    help="Model of contact between strands; repeatable.",
)
@moving(default=20)
@options.as_json
@record
def contact(segments: tuple[int, ...], between: tuple["Between", ...], moving: int, as_json: bool) -> None:
    """Measure hair in contact: seconds a frame of a shaking head, and their shares.

    Hair of 25 cm and 50 segments a strand on our bust, which turns to and fro by 60 degrees 1.5 times a second; strain
    limit and body; between hairs pairs (stiction and collisions), the same in locks, then a volume (a grid); 10 steps
    to a frame of 1/24 s. Medians over a few frames, after as many as hair takes to fall, touch, stick and be in locks.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.contact import BETWEEN, SEGMENTS, measure_contact

    print_report(measure_contact(echo, segments or SEGMENTS, between or BETWEEN, moving), as_json)


@bench.command()
@click.option("--hairs", type=click.IntRange(min=1), multiple=True, help="Number of hairs; repeatable.")
@click.option("--busy", "others", type=click.IntRange(min=0), multiple=True, help="Busy processes; repeatable.")
@options.as_json
@record
def busy(hairs: tuple[int, ...], others: tuple[int, ...], as_json: bool) -> None:
    """Measure hair next to busy programs: time that passes, and of processors, in a frame.

    60, 1,000 and 10,000 hairs of `bench contact`, in pairs, alone and next to 1, 2 and 4 processes that compute without
    end. Medians of five frames, after two.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.busy import BUSY, HAIRS, measure_busy

    print_report(measure_busy(echo, hairs or HAIRS, others or BUSY), as_json)


@bench.command()
@click.option(
    "--threads", type=click.IntRange(min=1), multiple=True, default=(1, 2), help="Number of threads; repeatable."
)
@click.option("--scene", "names", multiple=True, help="Scene to compute, by default all; repeatable.")
@options.as_json
@record
def digests(threads: tuple[int, ...], names: tuple[str, ...], as_json: bool) -> None:
    """Digest the values of small scenes of every model, scheme and precision: equal before and after a refactoring."""
    from hairpipe.graphs.experiments.bench.digests import measure_digests

    print_report(measure_digests(threads, names, echo), as_json)


@bench.command()
@options.as_json
@record
def volume(as_json: bool) -> None:
    """Measure hair as a volume: 10,000 hairs of 50 segments on a grid, and 100,000 interpolated between them.

    The motion of the roots, and bodies that hair is pushed out of, are not in it.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.volume import measure_volume

    print_report(measure_volume(echo), as_json)


@bench.command()
@options.as_json
@record
def levelset(as_json: bool) -> None:
    """Compare baked level sets with brute force: ours and, where its Python module is installed, OpenVDB's.

    Samples in the band, and as many within a voxel of the surface: distance to all triangles in double precision, sign
    by the winding number; of a box, a capsule and a thin plate, turned, and of our bust.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.level_sets import measure_level_sets

    print_report(measure_level_sets(echo), as_json)


@bench.command()
@click.option("--peers", metavar="NAME,...", help="Solvers to compare, by default all that are installed.")
@options.as_json
@record
def swing(peers: str | None, as_json: bool) -> None:
    """Compare solvers of strands: hairpipe, PyElastica, pyPBD, NVIDIA Newton on the processor.

    Hair of 30 cm swings for a second from 60 degrees, undamped and without contact: time per particle and frame of
    1/60 s, error of the tip to converged runs of hairpipe (200 segments, 15,360 steps a second) and of PyElastica,
    largest strain. Hair of 10 cm: the tip of a cantilever to the elastica, the lowest frequency to Euler and Bernoulli.
    Solvers that are not installed are left out: `pip install "hairpipe[peers]"`.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.swing import measure_swing
    from hairpipe.graphs.experiments.peers.registry import installed

    print_report(measure_swing(echo, installed(peers.split(",") if peers else None, echo)), as_json)


@bench.command()
@click.argument("folder", type=click.Path(path_type=Path))
@options.as_json
def page(folder: Path, as_json: bool) -> None:
    """Measure a report that `hairpipe report` has written: bytes on disk, and what opening it takes.

    That is processor seconds of all processes of a browser without a graphics card, until everything is drawn.
    """
    from hairpipe.graphs.experiments.bench.pictures.page import measure_page

    print_report(measure_page(folder), as_json)


@bench.command("page-frame")
@click.argument("graph", default="demo")
@click.option(
    "--edit",
    metavar="NODE.SETTING",
    default="hair.material.diameter",
    show_default=True,
    help="Number that is edited.",
)
@options.overrides
@options.as_json
@record
def page_frame(graph: str, edit: str, overrides: dict[str, str], as_json: bool) -> None:
    """Measure the page of `hairpipe view`: time from an edit to the first new frame in the viewport, by part.

    GRAPH has a node `hair`. Workers are those of earlier runs; medians of five edits. The page is in a browser, where
    chromium is installed; without one, requests are sent as the page sends them, and nothing is drawn. The second table
    is the server's part in processor seconds.
    """
    from hairpipe.app.api.source import find_graph
    from hairpipe.graphs.experiments.bench.pictures.page_frame import measure_page_frame

    path = find_graph(graph)
    print_report(measure_page_frame(str(path), overrides, edit), as_json, [path])


@bench.command()
@click.option("--strands", type=click.IntRange(min=1), default=100_000, show_default=True, help="Number of strands.")
@click.option("--points", type=click.IntRange(2, 1000), default=25, show_default=True, help="Points of a strand.")
@click.option("--redraws", type=click.IntRange(min=1), default=3, show_default=True, help="Number of redraws.")
@options.as_json
@record
def redraw(strands: int, points: int, redraws: int, as_json: bool) -> None:
    """Measure the viewport of the page: a redraw of hair from another eye, its uploads and draw calls, and a pick.

    The browser has no graphics card: its WebGL2 is a software renderer, whose frames a second are a lower bound for
    any card. Bytes, calls and vertices are those of every renderer.
    """
    from hairpipe.graphs.experiments.bench.pictures.redraw import measure_redraw

    print_report(measure_redraw(strands, points, redraws), as_json)


@bench.command()
@options.as_json
@record
def particles(as_json: bool) -> None:
    """Measure hair of particles: a frame of a shaking head, of 500 to 200,000 particles, at one step and at two.

    Hair acts on hair and on the level set of our bust. Processor time of one thread, over 12 frames of 1/24 s: their
    median, their least, and the medians of the parts. A link pass, measured in the same minutes, is the least work on
    a link, in double precision: two particles read, a force, and both written.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.particles import measure_particles

    print_report(measure_particles(echo), as_json)


@bench.command()
@options.as_json
@record
def picture(as_json: bool) -> None:
    """Measure a picture of hair at rest on our bust: processor seconds of `preview`, by part, and with deep shadows.

    720 x 720 pixels; 4,000 and 100,000 strands of 26 points, 10,000 of 51. The least of five takes, after one that
    compiles. Then luminance of locks by `shading = "dual"` and by Cycles, where Blender is installed.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.pictures.picture import measure_picture

    print_report(measure_picture(echo), as_json)


@bench.command()
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the choice and place of faults.")
@options.as_json
def faults(seed: int, as_json: bool) -> None:
    """Test the engine against faults: poisoned folders, kills, damaged stores, cleanings during runs.

    On a toy graph, in a temporary folder; it takes minutes. Each trial has to end with the bytes of an undisturbed
    run, or with a refusal of one line, and no result that is in the store may be computed again.

    Exit code 0: all trials passed, 1: some failed.
    """
    from hairpipe.formats.hdf5 import digest_file
    from hairpipe.graphs.experiments.bench.faults import held, try_faults

    report = try_faults(echo, digest_file, seed)
    print_report(report, as_json)
    sys.exit(0 if held(report) else 1)


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
