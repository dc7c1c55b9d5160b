"""Every argument and option that more than one command takes.

GRAPH        run plan explain graph get tune; --graph in nodes
TARGET       explain get
--set        run plan explain graph get tune bench
--frames     run plan explain get
--to         run plan graph
--publish-root  run plan
--cache      run plan explain get tune cache bench
--json       run plan explain nodes tune cache bench
"""

import os
import re
from pathlib import Path
from typing import NamedTuple

import click

from hairpipe.cli.completion import complete_graph, complete_node, complete_setting, complete_target
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain


class Target(NamedTuple):
    """A result: a node, which of its outputs, at which frame."""

    node: str
    output: str | None
    frame: int | None


def read_target(ctx: click.Context, param: click.Parameter, text: str) -> Target:
    """Read `NODE[.OUTPUT][@FRAME]`."""
    match = re.fullmatch(r"([^.@]+)(?:\.([^.@]+))?(?:@(-?\d{1,9}))?", text)
    if not match:
        raise BadInput(f"'{text}' names no result", right="NODE@FRAME, NODE.OUTPUT@FRAME, or NODE for the shot")
    return Target(match[1], match[2], int(match[3]) if match[3] else None)


def read_overrides(ctx: click.Context, param: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Read `NODE.SETTING=VALUE`, any number of times; the last one of a setting counts."""
    pairs = [text.partition("=") for text in given]
    for name, equals, _ in pairs:
        if not equals:
            raise BadInput(f"'{name}' sets nothing", where="--set", right="NODE.SETTING=VALUE")
    return {name.strip(): value for name, _, value in pairs}


def read_frames(ctx: click.Context, param: click.Parameter, text: str | None) -> tuple[int, ...] | None:
    """Read a set of frames; None where none is given."""
    from hairpipe.graph.file.frameset import parse_frames

    try:
        return None if text is None else parse_frames(text)
    except BadInput as fault:
        raise BadInput(fault.what, where="--frames", right=fault.right) from None


def read_cache(ctx: click.Context, param: click.Parameter, path: Path) -> Path:
    """Refuse what is no folder, nor can become one, and a store that is somebody else's."""
    from hairpipe.graph.store.ownership import check_store

    if ctx.resilient_parsing:
        return path
    check_plain(path, "a folder")
    if path.is_file():
        raise BadInput("it is a file", where=path, right="a folder")
    check_store(path)
    return path


graph = click.argument("graph", shell_complete=complete_graph)
target = click.argument("target", metavar="NODE[.OUTPUT][@FRAME]", callback=read_target, shell_complete=complete_target)
overrides = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="NODE.SETTING=VALUE",
    callback=read_overrides,
    shell_complete=complete_setting,
    help="Change a setting for this once; any number of times.",
)
frames = click.option(
    "--frames", metavar="1-100x2,150", callback=read_frames, help="Frames to look at; all of the graph by default."
)
to = click.option(
    "--to",
    multiple=True,
    metavar="NODE",
    shell_complete=complete_node,
    help="Only this node and what it depends on; any number of times.",
)
publish_root = click.option(
    "--publish-root",
    metavar="FOLDER",
    type=click.Path(path_type=Path),
    help="Folder below which the graph may publish, too; it may below the folder of its project.",
)
cache = click.option(
    "--cache",
    envvar="HAIRPIPE_CACHE",
    show_envvar=True,
    default=Path("cache"),
    show_default="cache in the current folder",
    callback=read_cache,
    type=click.Path(path_type=Path),
    help="Folder where results are kept.",
)
jobs = click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1, 1024),
    metavar="N",
    default=os.cpu_count,
    show_default="all cores",
    help="Processes, and threads of a simulation; no result depends on it.",
)
as_json = click.option("--json", "as_json", is_flag=True, help="One JSON document instead of text.")
