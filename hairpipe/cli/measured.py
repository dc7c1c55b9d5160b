"""What benches print: the machine, tables of measured values, and JSON documents."""

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from hairpipe.api.formatting import plural, table

if TYPE_CHECKING:
    from hairpipe.bench.machine import Machine


def show_machine(machine: "Machine") -> None:
    """Write what was measured on."""
    click.echo(f"{machine.processor}, {plural(machine.cores, 'core')}")
    click.echo(", ".join(f"{name} {version}" for name, version in machine.versions.items()))


def show_table(title: str, rows: list[tuple[str, ...]], text: int = 1) -> None:
    """Write a table with a title, its first columns being text, the others numbers."""
    click.echo(f"\n{title}\n{table(rows, '<' * text + '>' * (len(rows[0]) - text))}")


def tell(report: Any, show: Callable[[Any], None], as_json: bool) -> None:
    """Print a report, as a document or as people read it."""
    if as_json:
        click.echo(json.dumps(document(report), indent=2))
    else:
        show(report)


def document(report: Any) -> dict[str, Any]:
    """Describe the report as a JSON document."""

    def plain(value: Any) -> Any:
        if hasattr(value, "_asdict"):
            return plain(value._asdict())
        if isinstance(value, dict):
            return {str(key): plain(item) for key, item in value.items()}
        return [plain(item) for item in value] if isinstance(value, list) else value

    return plain(report)
