"""`hairpipe get`: a result out of the cache into a file."""

import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.cli import options
from hairpipe.cli.wording import shown, size
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain

if TYPE_CHECKING:
    from hairpipe.graph.node.signature import File


@click.command()
@options.graph
@options.target
@options.frames
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="File to write.")
@options.overrides
@options.cache
def get(
    graph: str,
    target: options.Target,
    frames: tuple[int, ...] | None,
    output: Path,
    overrides: dict[str, str],
    cache: Path,
) -> None:
    """Write a result to a file.

    HDF5 (.h5), NPZ (.npz), CSV (.csv) or USD (.usd, .usda, .usdc), by the suffix of the file.

    NODE@FRAME is the first output of a node at a frame, NODE.OUTPUT@FRAME another one. HDF5 and NPZ hold any value;
    CSV and USD what has points: meshes and hair. A result that is a file already is copied as it is.

    A result that looks at all frames of a run is found by the --frames of that run.
    """
    from hairpipe.cli.shipped import open_graph
    from hairpipe.graph import File
    from hairpipe.graph.plan.tasks import Task
    from hairpipe.graph.results import read_result
    from hairpipe.graph.store.store import Store
    from hairpipe.io.value import write_value

    opened, store = open_graph(graph, overrides), Store(cache)
    value = read_result(opened, store, Task(target.node, target.frame), target.output, frames)
    frame = opened.frames[0] if target.frame is None else target.frame
    if output.is_dir():
        raise BadInput("is a folder", where=output, right="the name of a file")
    check_plain(output, "the name of a file")
    if isinstance(value, File):
        copy(value, output)
    else:
        write_value(output, value, frame, opened.fps)
    click.echo(f"{shown(output)}  {size(output.stat().st_size)}")


def copy(file: "File", output: Path) -> None:
    """Copy a file, and those that lie beside it."""
    from hairpipe.graph.store.atomic import replacing

    for target, source in {output: file.path, **{output.parent / n: p for n, p in file.companions.items()}}.items():
        with replacing(target) as temporary:
            shutil.copyfile(source, temporary)
