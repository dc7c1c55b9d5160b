"""`hairpipe cache`: list, verify and clean the cache of results."""

import json
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path

import click

import hairpipe
from hairpipe.app.api.formatting import duration, plural, shown, size, table
from hairpipe.app.cli import options
from hairpipe.engine.node.messages import one_line
from hairpipe.errors import BadInput

AGES = {"s": 1, "min": 60, "h": 3600, "d": 86400, "w": 7 * 86400}
SIZES = {"": 1, "B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}


def measured(units: dict[str, int]) -> Callable:
    """Return a parser of a number with a unit, such as 7d or 20GB."""

    def read(ctx: click.Context, param: click.Parameter, text: str | None) -> float | None:
        if text is None:
            return None
        match = re.fullmatch(r"(\d{1,15}(?:\.\d{1,9})?)\s*([A-Za-z]*)", text.strip())
        if not match or match[2] not in units:
            right = f"a number and one of {', '.join(filter(None, units))}"
            raise BadInput(f"'{text}' is not a measure", where=param.opts[0], right=right)
        return float(match[1]) * units[match[2]]

    return read


@click.group()
def cache() -> None:
    """List, verify and clean the folder of results."""


@cache.command()
@options.cache
@options.as_json
def ls(cache: Path, as_json: bool) -> None:
    """List the results, the most recently used first."""
    rows = [["result", "type", "size", "computed in", "used", "key"]]
    documents = []
    for item in hairpipe.Cache(cache).results():
        record = item.record
        kind = item.record.parts["type"]
        names = ("key", "node", "frame", "seconds", "created")
        documents.append({n: getattr(record, n) for n in names} | {"type": kind, "size": item.size, "used": item.used})
        name = record.node if record.frame is None else f"{record.node}@{record.frame}"
        ago = f"{duration(max(0.0, time.time() - item.used))} ago"
        rows.append([name, kind, size(item.size), duration(record.seconds), ago, record.key[:12]])
    if as_json:
        click.echo(json.dumps({"results": documents}, indent=2))
    elif documents:
        click.echo(table(rows, "<<>>><"))


@cache.command()
@options.cache
@options.as_json
def du(cache: Path, as_json: bool) -> None:
    """Sum the disk space by node type."""
    used = hairpipe.Cache(cache).usage()
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
    """Read every result and every compiled kernel, and remove damaged ones, which the next run computes again.

    Exit code 0: all files are intact, 1: a file was damaged or could not be read.
    """
    found = hairpipe.Cache(cache).verify()
    if as_json:
        click.echo(json.dumps({"cache": str(cache), "damaged": found.damaged, "unread": found.unread}, indent=2))
    else:
        lines = [f"{plural(len(found.damaged), 'file')} damaged and removed"] if found.damaged else []
        lines += [f"{plural(len(found.unread), 'file')} not known to be whole"] if found.unread else []
        click.echo("\n".join([*map(one_line, [*found.damaged, *found.unread]), *(lines or ["all whole"])]))
    sys.exit(1 if found.damaged or found.unread else 0)


@cache.command()
@options.graphs
@click.option(
    "--older", metavar="7d", callback=measured(AGES), help="Minimum time since the last use of a removed result."
)
@click.option(
    "--size",
    "limit",
    metavar="20GB",
    callback=measured(SIZES),
    help="Size of the cache at which removal ends.",
)
@click.option("--dry-run", is_flag=True, help="List removable results, without removing them.")
@options.cache
@options.as_json
def gc(
    graphs: tuple[str, ...], older: float | None, limit: float | None, dry_run: bool, cache: Path, as_json: bool
) -> None:
    """Remove results, the least recently used first; results of the given graphs are kept."""
    if not graphs and older is None and limit is None:
        raise BadInput("no criterion of what to keep", where="gc", right="graphs, --older or --size")
    keep = [hairpipe.load(graph, cache=cache) for graph in graphs]
    gone = hairpipe.Cache(cache).clean(keep, older=older or 0.0, size=int(limit or 0), dry_run=dry_run)
    if as_json:
        document = {"cache": str(cache), "dry_run": dry_run, "results": gone.records, "objects": gone.objects}
        click.echo(json.dumps(document | {"size": gone.size}, indent=2))
    else:
        verb = "would go" if dry_run else "removed"
        click.echo(f"{plural(gone.records, 'result')}, {size(gone.size)} {verb} from {shown(cache)}")


@cache.command()
@options.cache
@options.as_json
def doctor(cache: Path, as_json: bool) -> None:
    """Check whether the folder of results supports several runs, users and machines.

    Exit code 0: it does, 1: results could be damaged or computed twice.
    """
    found = []
    for finding in hairpipe.Cache(cache).diagnose():
        found.append(finding)
        if not as_json:
            click.echo(one_line(f"{finding.verdict:5}  {finding.check:18}  {finding.result}; {finding.meaning}"))
    if as_json:
        click.echo(json.dumps({"cache": str(cache), "findings": [item._asdict() for item in found]}, indent=2))
    sys.exit(1 if any(item.verdict == "fault" for item in found) else 0)
