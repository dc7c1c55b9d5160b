"""What benches print: the machine, tables of measured values, and JSON documents."""

import json
import math
import shlex
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.app.api.formatting import plural, table

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.bench.report import Report

RECORDING = "hairpipe.recording"
"""What records the report of a command, in the meta data of its context."""


def show(report: "Report") -> None:
    """Write the machine, and every table: columns of text to the left, numbers to the right."""
    machine = report.machine
    click.echo(f"{machine.processor}, {plural(machine.cores, 'core')}")
    click.echo(", ".join(f"{name} {version}" for name, version in machine.versions.items()))
    for title, cases in report.tables.items():
        columns = list(dict.fromkeys(name for case in cases for name in case))
        values = [[case.get(name) for name in columns] for case in cases]
        has_text = (any(isinstance(value, str) for value in column) for column in zip(*values, strict=True))
        align = "".join("<" if text else ">" for text in has_text)
        click.echo(f"\n{title}\n{table([columns, *([written(value) for value in row] for row in values)], align)}")


def written(value: str | int | float | None) -> str:
    """Write a value as people read it: of a fraction, three significant digits."""
    if isinstance(value, float) and value != 0.0 and math.isfinite(value):
        digits = max(0, 2 - math.floor(math.log10(abs(value))))
        return f"{value:,.{digits}f}"
    return "" if value is None else f"{value:,}" if isinstance(value, int) else str(value)


def print_report(report: "Report", as_json: bool, files: Iterable[Path] = ()) -> None:
    """Print a report, as a document or as people read it, and record it where `--record` asks for that.

    files  that it was made from besides its code
    """
    recording = click.get_current_context().meta.get(RECORDING)
    if recording is not None:
        recording.write(report, measuring_command(), files)
    if as_json:
        click.echo(json.dumps(report._asdict() | {"machine": report.machine._asdict()}, indent=2))
    else:
        show(report)


def prepare_recording(ctx: click.Context, param: click.Parameter, place: Path | None) -> None:
    """Check that a report can be recorded, before anything is measured; BadInput where it cannot be."""
    if place is not None:
        from hairpipe.graphs.experiments.figures.bench_recording import BenchRecording

        folder, name = (place, str(ctx.info_name)) if place.is_dir() else (place.parent, place.name)
        ctx.meta[RECORDING] = BenchRecording(folder, name)


record = click.option(
    "--record",
    metavar="FOLDER[/NAME]",
    type=click.Path(path_type=Path),
    callback=prepare_recording,
    expose_value=False,
    help="Folder of the page for which results/NAME.json keeps the tables; by default, NAME is that of the bench.",
)
moving = partial(
    click.option,
    "--moving",
    type=click.IntRange(min=0),
    show_default=True,
    help="Number of frames before the measured ones, for locks to form.",
)


def measuring_command() -> str:
    """Write the command of this process, without what changes no result."""
    program = str(click.get_current_context().find_root().info_name).split()
    words = iter(sys.argv[1:])
    kept = []
    for word in words:
        if word == "--cache":
            next(words, None)
        elif word != "--json" and not word.startswith("--cache="):
            kept.append(word)
    return shlex.join([*program, *kept])
