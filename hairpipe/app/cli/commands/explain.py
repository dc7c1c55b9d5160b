"""`hairpipe explain`: the inputs of one result, and its differences to the latest one."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

import hairpipe
from hairpipe.app.cli import options

if TYPE_CHECKING:
    from hairpipe.app.api.selection import Target


@click.command()
@options.graph
@options.target
@options.frames
@options.overrides
@options.cache
@options.as_json
def explain(
    graph: str,
    target: "Target",
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    cache: Path,
    as_json: bool,
) -> None:
    """Explain one result: inputs, state, what is different.

    The result is that of a node at a frame, `hair@12`, or of a node that has one value for the shot, `groom`.
    """
    found = hairpipe.load(graph, options.parsed(overrides), cache=cache).explain(target, frames=frames)
    click.echo(json.dumps(found.document(), indent=2) if as_json else repr(found))
