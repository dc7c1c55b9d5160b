"""`hairpipe get`: write a result from the cache to a file."""

import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import click

import hairpipe
from hairpipe.app.api.formatting import shown, size
from hairpipe.app.cli import options
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain

if TYPE_CHECKING:
    from hairpipe.app.api.selection import Target
    from hairpipe.engine import File


@click.command()
@options.graph
@options.target
@options.frames
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="Path of the file to write.")
@options.overrides
@options.cache
def get(
    graph: str,
    target: "Target",
    frames: tuple[int, ...] | None,
    output: Path,
    overrides: dict[str, str],
    cache: Path,
) -> None:
    """Write a result to a file.

    The format is given by the suffix: HDF5 (.h5), NPZ (.npz), CSV (.csv) or USD (.usd, .usda, .usdc).

    NODE@FRAME is the first output of a node at a frame, NODE.OUTPUT@FRAME another one. HDF5 and NPZ hold any value;
    CSV and USD meshes and hair. A result that is a file is copied unchanged.

    A result that depends on all frames of a run is found with the --frames of that run.
    """
    from hairpipe.engine import File
    from hairpipe.formats.values import write_value

    shot = hairpipe.load(graph, options.parsed(overrides), cache=cache)
    value = shot.get(shot.single(target), frames=frames)
    frame = shot.frames[0] if target.frame is None else target.frame
    if output.is_dir():
        raise BadInput("is a folder", where=output, right="the name of a file")
    check_plain(output, "the name of a file")
    if isinstance(value, File):
        copy(value, output)
    else:
        write_value(output, value, frame, shot.fps)
    click.echo(f"{shown(output)}  {size(output.stat().st_size)}")


def copy(file: "File", output: Path) -> None:
    from hairpipe.engine.store.atomic import keep_mode, replacing

    for target, source in {output: file.path, **{output.parent / n: p for n, p in file.companions.items()}}.items():
        with replacing(target) as temporary:
            shutil.copyfile(source, temporary)
            keep_mode(temporary, target)
