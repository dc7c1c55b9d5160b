"""`hairpipe bench`: what hair costs on this machine."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.api.formatting import plural
from hairpipe.cli import measured, options
from hairpipe.cli.measured import show_machine, show_table, tell
from hairpipe.cli.stderr import say

if TYPE_CHECKING:
    from hairpipe.bench.first_use import Report as FirstUseReport
    from hairpipe.bench.paper import Report as PaperReport


@click.group()
def bench() -> None:
    """Measure what hair costs on this machine."""


@bench.command()
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@options.moving(default=5)
@options.overrides
@options.cache
@options.as_json
@measured.record
def paper(scenes: tuple[str, ...], moving: int, overrides: dict[str, str], cache: Path, as_json: bool) -> None:
    """Reproduce Table 2 of Selle, Lentine, Fedkiw 2008: seconds a frame of the scenes in graphs/paper.

    A frame is 1/24 s, all physics is on. The simulation starts at half a second of the shot, where the head is in full
    motion; medians over the three frames after those that let it move.
    Without a SCENE, those of the paper. The inputs of the simulation are kept in the cache.
    """
    from hairpipe.bench.machine import share_kernels

    share_kernels()  # before kernels are imported
    from hairpipe.api.source import find_graph
    from hairpipe.bench.paper import PRINTED, measure_paper

    cache.mkdir(parents=True, exist_ok=True)
    graphs = {name: find_graph(f"paper/{name}") for name in scenes or PRINTED}
    report = measure_paper(say, graphs, cache, overrides, moving)
    tell(report, show_paper, as_json, graphs.values())


def show_paper(report: "PaperReport") -> None:
    """Write the table."""
    machine = report.machine
    click.echo(f"{machine.processor}, {plural(machine.cores, 'core')}; the paper: one to four machines of 4 processors")
    heads = "scene", "strands", "simulated", "particles", "frame", "memory so far", "theirs", "frame"
    times: list[tuple[str, ...]] = [heads]
    parts: list[tuple[str, ...]] = [("scene", *report.rows[0].shares)]
    for row in report.rows:
        theirs = ("", "") if row.printed is None else (f"{row.printed.particles:,}", f"{60 * row.printed.minutes:.0f}")
        counts = f"{row.strands:,}", f"{row.simulated:.0%}", f"{row.particles:,}"
        ours = (*counts, f"{row.seconds:.1f}", f"{row.memory / 1e9:.1f} GB")
        times.append((row.scene, *ours, *theirs))
        parts.append((row.scene, *(f"{seconds:.1f}" for seconds in row.shares.values())))
    show_table("seconds per frame; last columns: particles and seconds of the paper", times)
    show_table("parts of it", parts)


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

    phases = measure_first_frame(find_graph(graph), overrides)
    if as_json:
        click.echo(json.dumps(phases, indent=2))
    else:
        rows: list[tuple[str, ...]] = [("phase", "s"), *((name, f"{value:.2f}") for name, value in phases.items())]
        show_table("processor seconds on one thread", rows)


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

    report = measure_first_use(find_graph(graph), overrides)
    tell(report, show_first_use, as_json)


def show_first_use(report: "FirstUseReport") -> None:
    """Write the report on the first use of a graph."""
    show_machine(report.machine)
    click.echo(f"{report.cold:.1f} processor seconds without kernels, {report.warm:.1f} with them")
    total = f"{sum(report.kernels.values()):,} kernels of {len(report.kernels):,} functions"
    rows = [(name, str(count)) for name, count in report.kernels.items() if count > 1]
    show_table(f"{total}; those of several specialisations", [("function", "kernels"), *rows])
