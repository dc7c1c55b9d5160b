"""Benches of parts of hairpipe, started as `python -m hairpipe.graphs.experiments.bench`."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.api.formatting import duration, plural, size
from hairpipe.bench.machine import share_kernels
from hairpipe.cli import measured, options
from hairpipe.cli.entry import Group
from hairpipe.cli.measured import document, show_machine, show_table, tell
from hairpipe.cli.stderr import say
from hairpipe.graphs.experiments.bench.scene_commands import PROGRAM, needs, promises

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.bench.contact import Report as ContactReport
    from hairpipe.graphs.experiments.bench.core import Case, Report
    from hairpipe.graphs.experiments.bench.faults import Report as FaultReport
    from hairpipe.graphs.experiments.bench.head import Between
    from hairpipe.graphs.experiments.bench.particles import Report as ParticleReport
    from hairpipe.graphs.experiments.bench.pictures.page import Report as PageReport
    from hairpipe.graphs.experiments.bench.pictures.picture import Report as PictureReport
    from hairpipe.graphs.experiments.bench.repeat import Spread
    from hairpipe.graphs.experiments.bench.roofs import Roofs
    from hairpipe.graphs.experiments.bench.volume import Report as VolumeReport

__all__ = ["PROGRAM", "bench"]


@click.group(cls=Group)
def bench() -> None:
    """Measure what parts of hairpipe cost on this machine, and what they withstand."""


bench.add_command(promises)
bench.add_command(needs)


@bench.command()
@options.as_json
@measured.record
def core(as_json: bool) -> None:
    """Measure the strand core: time per particle of a solve and of a step, for every model of a strand.

    A solve is one linearly implicit stage: forces, choice of altitude springs, assembly, factorisation and
    substitution. For comparison, measured in the same minutes: the peak arithmetic rate and memory bandwidth of
    the machine, the lower bound they set for a solve, and the time of a prototype. Medians, with the middle half of
    all runs.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.core import measure_core

    report = measure_core(say)  # lines: whatever moves on the screen would be measured, too
    tell(report, show, as_json)


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
@options.moving(default=20)
@options.as_json
@measured.record
def contact(segments: tuple[int, ...], between: tuple["Between", ...], moving: int, as_json: bool) -> None:
    """Measure hair in contact: seconds a frame of a shaking head, and their shares.

    Hair of 25 cm and 50 segments a strand on our bust, which turns to and fro by 60 degrees 1.5 times a second; strain
    limit and body; between hairs pairs (stiction and collisions), the same in locks, then a volume (a grid); 10 steps
    to a frame of 1/24 s. Medians over a few frames, after as many as hair takes to fall, touch, stick and be in locks.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.contact import FULL, measure_contact

    chosen = segments or FULL.segments, between or FULL.between
    sizes = FULL._replace(segments=chosen[0], between=chosen[1], moving=moving)
    report = measure_contact(say, sizes)
    tell(report, show_contact, as_json)


@bench.command()
@options.as_json
@measured.record
def volume(as_json: bool) -> None:
    """Measure hair as a volume: 10,000 hairs of 50 segments on a grid, and 100,000 interpolated between them.

    The motion of the roots, and bodies that hair is pushed out of, are not in it.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.volume import measure_volume

    report = measure_volume(say)
    tell(report, show_volume, as_json)


def show_volume(report: "VolumeReport") -> None:
    """Write the report on hair as a volume."""
    show_machine(report.machine)
    rows = [(case.kernel, case.each, str(case.threads), spread(case.time, 1.0)) for case in report.cases]
    show_table("ns", [("kernel", "for each", "threads", "median (half between)"), *rows], text=2)


@bench.command()
@click.argument("folder", type=click.Path(path_type=Path))
@options.as_json
def page(folder: Path, as_json: bool) -> None:
    """Measure a report that `hairpipe report` has written: bytes on disk, and what opening it takes.

    That is processor seconds of all processes of a browser without a graphics card, until everything is drawn.
    """
    from hairpipe.graphs.experiments.bench.pictures.page import measure_page

    report = measure_page(folder)
    tell(report, show_page, as_json)


def show_page(report: "PageReport") -> None:
    """Write the report on a page."""
    show_machine(report.machine)
    click.echo(f"{report.files} files, {size(report.bytes)}; {report.opening:.1f} s of processor to open")


@bench.command()
@options.as_json
@measured.record
def particles(as_json: bool) -> None:
    """Measure hair of particles: a frame of a shaking head, of 500 to 200,000 particles, at one step and at two.

    Hair acts on hair and on the level set of our bust. Processor time of one thread, over 12 frames of 1/24 s: their
    median, their least, and the medians of the parts. A link pass, measured in the same minutes, is the least work on
    a link, in double precision: two particles read, a force, and both written.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.particles import measure_particles

    report = measure_particles(say)
    tell(report, show_particles, as_json)


@bench.command()
@options.as_json
@measured.record
def picture(as_json: bool) -> None:
    """Measure a picture of hair at rest on our bust: processor seconds of `preview`, by part, and with deep shadows.

    720 x 720 pixels; 4,000 and 100,000 strands of 26 points, 10,000 of 51. The least of five takes, after one that
    compiles. Then luminance of locks by `shading = "dual"` and by Cycles, where Blender is installed.
    """
    share_kernels()
    from hairpipe.graphs.experiments.bench.pictures.picture import measure_picture

    report = measure_picture(say)
    tell(report, show_picture, as_json)


def show_picture(report: "PictureReport") -> None:
    """Write the report on pictures."""
    show_machine(report.machine)
    heads = "strands", "points", "whole", *report.cases[0].shares, "with deep shadows", "knots a texel"
    rows: list[tuple[str, ...]] = [heads]
    for case in report.cases:
        seconds = (f"{value:.2f}" for value in (case.seconds, *case.shares.values(), case.deep))
        rows.append((f"{case.strands:,}", str(case.points), *seconds, f"{case.knots:.1f}"))
    show_table("processor seconds; knots of deep shadow maps", rows)
    if report.locks:
        locks = [(x.colour, f"{x.dual:.4f}", f"{x.traced:.4f}", f"{x.dual / x.traced:.2f}") for x in report.locks]
        show_table("luminance of a lock", [("colour", "dual", "Cycles", "ratio"), *locks])


@bench.command()
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the choice and place of faults.")
@options.as_json
def faults(seed: int, as_json: bool) -> None:
    """Test the engine against faults: poisoned folders, kills, damaged stores, cleanings during runs.

    On a toy graph, in a temporary folder; it takes minutes. Each trial has to end with the bytes of an undisturbed
    run, or with a refusal of one line, and no result that is in the store may be computed again.

    Exit code 0: all trials passed, 1: some failed.
    """
    from hairpipe.graphs.experiments.bench.faults import try_faults
    from hairpipe.io.hdf5 import digest_file

    report = try_faults(say, digest_file, seed)
    if as_json:
        click.echo(json.dumps(document(report) | {"held": report.held}, indent=2))
    else:
        show_faults(report)
    sys.exit(0 if report.held else 1)


def show_faults(report: "FaultReport") -> None:
    """Write what was tried and what did not hold."""
    rows: list[tuple[str, ...]] = [("", "", "trials", "same bytes", "refused", "faults", "done twice")]
    for row in report.rows:
        numbers = (row.tries, row.same, row.refused, len(row.faults), row.twice)
        rows.append((row.campaign, row.kind, *(f"{number:,}" for number in numbers)))
    show_table(f"seed {report.seed}, {duration(report.seconds)}", rows, text=2)
    for fault in [fault for row in report.rows for fault in row.faults]:
        click.echo(fault)


def show_contact(report: "ContactReport") -> None:
    """Write the report on contact as tables."""
    show_machine(report.machine)
    rows: list[tuple[str, ...]] = [
        ("segments", "between", "particles", "simulated", "connections", "threads", "frame", *report.cases[0].shares)
    ]
    for case in report.cases:
        shares = (f"{seconds:.2f}" for seconds in case.shares.values())
        counts = f"{case.particles:,}", f"{case.simulated:.0%}", f"{case.stuck:,}", str(case.threads)
        rows.append((f"{case.segments:,}", case.between, *counts, f"{case.seconds:.2f}", *shares))
    show_table(f"seconds a frame of {report.steps} steps", rows, text=2)
    show_roofs(report.roofs)


def show_particles(report: "ParticleReport") -> None:
    """Write the report on particles as tables."""
    show_machine(report.machine)
    rows: list[tuple[str, ...]] = [
        ("particles", "links", "pairs", "steps", "iterations", "median", "least", "us each", "link passes")
    ]
    parts: list[tuple[str, ...]] = [("particles", "steps", *report.cases[0].shares)]
    for case in report.cases:
        named, each = (f"{case.particles:,}", str(case.steps)), case.least / case.particles
        numbers = f"{case.links:,}", f"{case.pairs:,.0f}", str(case.steps), f"{case.iterations:.1f}"
        times = f"{1e3 * case.median:.2f}", f"{1e3 * case.least:.2f}", f"{1e6 * each:.2f}"
        rows.append((named[0], *numbers, *times, f"{each / report.link_pass:.0f}"))
        parts.append((*named, *(f"{1e3 * seconds:.2f}" for seconds in case.shares.values())))
    show_table(f"ms a frame; for each particle, and in link passes, of {1e9 * report.link_pass:.1f} ns a link", rows)
    show_table("ms, its parts", parts)


def show(report: "Report") -> None:
    """Write the report as tables."""
    show_machine(report.machine)
    heading = ("kernel", "model", "in", "numbers", "threads", "median", "half between", "floor", "prototype", "ratio")
    show_table("ns per particle", [heading, *map(row_of, report.cases)], text=4)
    show_table(
        "ns per segment of a strand", [("kernel", "in", "numbers", "threads", *report.work), *by_model(report)], 3
    )
    click.echo("(in brackets: over the network's)")
    sizes = report.sizes
    click.echo(f"(strands of {sizes.segments} segments; {sizes.cache:,} in cache, {sizes.memory:,} in memory)")
    show_roofs(report.roofs)
    code: list[tuple[str, ...]] = [("", "", "flop/particle", "bytes/particle", "zmm", "ymm", "xmm", "scalar")]
    for model, works in report.work.items():
        for dtype, work in works.items():
            counted = map(str, report.code[model][dtype])
            code.append((model, dtype, f"{work.operations:.0f}", f"{work.bytes:.0f}", *counted))
    show_table("a solve", code, text=2)
    click.echo("(the last four: instructions of arithmetic, on vectors of 64, 32, 16 bytes and on one number)\n")
    click.echo(f"every kernel of a frame compiled, with an empty cache: {duration(report.compiled)}")


def show_roofs(roofs: "Roofs") -> None:
    """Write what the machine could do at best."""
    rows = [
        (f"multiply-add, {dtype}, 1 thread", spread(rate, 1e-9) + " GFLOP/s")
        for dtype, rate in roofs.multiply_add.items()
    ]
    rows += [
        (f"triad, {plural(threads, 'thread')}", spread(rate, 1e-9) + " GB/s") for threads, rate in roofs.triad.items()
    ]
    show_table("peak of this machine", rows, text=2)


def row_of(case: "Case") -> tuple[str, ...]:
    """Write a case as a row."""
    return (
        case.kernel,
        case.model,
        case.place,
        case.dtype,
        str(case.threads),
        f"{case.time.median:.1f}",
        f"{case.time.low:.1f}-{case.time.high:.1f}",
        "" if case.floor is None else f"{case.floor:.1f}",
        "" if case.prototype is None else f"{case.prototype:.1f}",
        "" if case.prototype is None else f"{case.time.median / case.prototype:.2f}",
    )


def by_model(report: "Report") -> Iterator[tuple[str, ...]]:
    """Write rows that have the models next to each other."""
    found = {(case.kernel, case.place, case.dtype, case.threads): {} for case in report.cases}
    for case in report.cases:
        found[case.kernel, case.place, case.dtype, case.threads][case.model] = case.segment
    for (*where, threads), times in found.items():
        shown = (f"{times[model]:.1f} ({times[model] / times['network']:.2f})" for model in report.work)
        yield (*where, str(threads), *shown)


def spread(value: "Spread", unit: float) -> str:
    """Write a median and the middle half."""
    return f"{value.median * unit:.1f} ({value.low * unit:.1f}-{value.high * unit:.1f})"
