"""What benches print: the machine, tables of measured values, and JSON documents."""

import json
import shlex
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hairpipe.api.formatting import plural, table

if TYPE_CHECKING:
    from hairpipe.bench.machine import Machine

RECORDING = "hairpipe.recording"
"""What records the report of a command, in the meta data of its context."""


def show_machine(machine: "Machine") -> None:
    """Write what was measured on."""
    click.echo(f"{machine.processor}, {plural(machine.cores, 'core')}")
    click.echo(", ".join(f"{name} {version}" for name, version in machine.versions.items()))


def show_table(title: str, rows: list[tuple[str, ...]], text: int = 1) -> None:
    """Write a table with a title, its first columns being text, the others numbers."""
    click.echo(f"\n{title}\n{table(rows, '<' * text + '>' * (len(rows[0]) - text))}")


def tell(report: Any, show: Callable[[Any], None], as_json: bool, files: Iterable[Path] = ()) -> None:
    """Print a report, as a document or as people read it, and record it where `--record` asks for that.

    files  that it was made from besides its code
    """
    recording = click.get_current_context().meta.get(RECORDING)
    if recording is not None:
        recording.write(report, document(report), measuring_command(), files)
    if as_json:
        click.echo(json.dumps(document(report), indent=2))
    else:
        show(report)


def prepare_recording(ctx: click.Context, param: click.Parameter, folder: Path | None) -> None:
    """Check that a report can be recorded, before anything is measured; BadInput where it cannot be."""
    if folder is not None:
        from hairpipe.results.bench_recording import BenchRecording

        ctx.meta[RECORDING] = BenchRecording(folder, str(ctx.info_name))


record = click.option(
    "--record",
    metavar="FOLDER",
    type=click.Path(path_type=Path, exists=True, file_okay=False),
    callback=prepare_recording,
    expose_value=False,
    help="Folder of the page for which results/NAME.json keeps the tables.",
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


def document(report: Any) -> dict[str, Any]:
    """Describe the report as a JSON document."""

    def plain(value: Any) -> Any:
        if hasattr(value, "_asdict"):
            return plain(value._asdict())
        if isinstance(value, dict):
            return {str(key): plain(item) for key, item in value.items()}
        return [plain(item) for item in value] if isinstance(value, list) else value

    return plain(report)
