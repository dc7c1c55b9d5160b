"""`hairpipe cache`: what is kept, whether it is whole, and what may go."""

import json
import re
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.cli import completion, options
from hairpipe.cli.wording import duration, plural, shown, size, table
from hairpipe.errors import BadInput
from hairpipe.graph.node.messages import one_line

if TYPE_CHECKING:
    from hairpipe.graph.plan.gc import Item

AGES = {"s": 1, "min": 60, "h": 3600, "d": 86400, "w": 7 * 86400}
SIZES = {"": 1, "B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}


def measured(units: dict[str, int]) -> Callable:
    """Make a reader of a number with a unit, such as 7d or 20GB."""

    def read(ctx: click.Context, param: click.Parameter, text: str | None) -> float | None:
        if text is None:
            return None
        match = re.fullmatch(r"(\d{1,15}(?:\.\d{1,9})?)\s*([A-Za-z]*)", text.strip())
        if not match or match[2] not in units:
            right = f"a number and one of {', '.join(filter(None, units))}"
            raise BadInput(f"'{text}' is no measure", where=param.opts[0], right=right)
        return float(match[1]) * units[match[2]]

    return read


@click.group()
def cache() -> None:
    """Look after the folder where results are kept."""


@cache.command()
@options.cache
@options.as_json
def ls(cache: Path, as_json: bool) -> None:
    """List the results, the latest used first."""
    from hairpipe.graph.plan.gc import items
    from hairpipe.graph.store.store import Store

    found = sorted(items(Store(cache, read_only=True)), key=lambda item: -item.used)
    if as_json:
        click.echo(json.dumps({"results": [described(item) for item in found]}, indent=2))
    elif found:
        click.echo(table([("result", "type", "size", "computed in", "used", "key"), *map(row_of, found)], "<<>>><"))


def row_of(item: "Item") -> tuple[str, ...]:
    """Write a result as a row."""
    record = item.record
    name = record.node if record.frame is None else f"{record.node}@{record.frame}"
    ago = f"{duration(max(0.0, time.time() - item.used))} ago"
    return name, record.parts["type"], size(item.size), duration(record.seconds), ago, record.key[:12]


def described(item: "Item") -> dict[str, object]:
    """Describe a result as a JSON document."""
    record = item.record
    return {
        "key": record.key,
        "node": record.node,
        "frame": record.frame,
        "type": record.parts["type"],
        "size": item.size,
        "seconds": record.seconds,
        "created": record.created,
        "used": item.used,
    }


@cache.command()
@options.cache
@options.as_json
def du(cache: Path, as_json: bool) -> None:
    """Add up the disk space by node type."""
    from hairpipe.graph.plan.gc import usage
    from hairpipe.graph.store.store import Store

    used = usage(Store(cache, read_only=True))
    if as_json:
        rows = {name: {"results": count, "size": total} for name, (count, total) in used.items()}
        click.echo(json.dumps({"cache": str(cache), "types": rows}, indent=2))
        return
    ordered = sorted(used.items(), key=lambda pair: -pair[1][1])
    rows = [(name, f"{count:,}", size(total)) for name, (count, total) in ordered]
    whole = ("total", f"{sum(count for count, _ in used.values()):,}", size(sum(total for _, total in used.values())))
    click.echo(table([("type", "results", "size"), *rows, whole], "<>>"))


@cache.command()
@options.cache
@options.as_json
def verify(cache: Path, as_json: bool) -> None:
    """Read everything; remove what is damaged, so that the next run computes it again. Compiled kernels are read too.

    Exit code 0: all is whole, 1: something was damaged, or could not be read.
    """
    from hairpipe.graph.plan.gc import verify as read_all
    from hairpipe.graph.run.machine_code import kernels_parent
    from hairpipe.graph.store.store import Store
    from hairpipe.io.hdf5 import digest_file

    kernels: Path | None = None
    with suppress(OSError):  # without a home none are kept
        kernels = kernels_parent()
    found = read_all(Store(cache), digest_file, kernels)
    if as_json:
        click.echo(json.dumps({"cache": str(cache), "damaged": found.damaged, "unread": found.unread}, indent=2))
    else:
        lines = [f"{plural(len(found.damaged), 'file')} damaged and removed"] if found.damaged else []
        lines += [f"{plural(len(found.unread), 'file')} not known to be whole"] if found.unread else []
        click.echo("\n".join([*map(one_line, [*found.damaged, *found.unread]), *(lines or ["all whole"])]))
    sys.exit(1 if found.damaged or found.unread else 0)


@cache.command()
@click.argument("graphs", nargs=-1, metavar="[GRAPH]...", shell_complete=completion.complete_graph)
@click.option("--older", metavar="7d", callback=measured(AGES), help="Only what was not used for this long goes.")
@click.option("--size", "limit", metavar="20GB", callback=measured(SIZES), help="Only as much goes as has to.")
@click.option("--dry-run", is_flag=True, help="Only say what would go.")
@options.cache
@options.as_json
def gc(
    graphs: tuple[str, ...], older: float | None, limit: float | None, dry_run: bool, cache: Path, as_json: bool
) -> None:
    """Remove results, the least recently used first; those that the given graphs reach stay in any case."""
    from hairpipe.cli.shipped import open_graph
    from hairpipe.graph.plan.gc import clean, live_keys
    from hairpipe.graph.store.store import Store

    if not graphs and older is None and limit is None:
        raise BadInput("nothing says what to keep", where="gc", right="graphs, --older or --size")
    keep = live_keys(Store(cache), [open_graph(graph, {}) for graph in graphs])
    gone = clean(Store(cache, read_only=dry_run), keep=keep, older=older or 0.0, size=int(limit or 0))
    if as_json:
        document = {"cache": str(cache), "dry_run": dry_run, "results": gone.records, "objects": gone.objects}
        click.echo(json.dumps(document | {"size": gone.size}, indent=2))
    else:
        verb = "would go" if dry_run else "removed"
        click.echo(f"{plural(gone.records, 'result')}, {size(gone.size)} {verb} from {shown(cache)}")
