"""`hairpipe convert`: a file of another program as USD."""

from pathlib import Path

import click

from hairpipe.plain_file import check_plain


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("output", type=click.Path(path_type=Path))
def convert(file: Path, output: Path) -> None:
    """Write a file that Blender reads as USD.

    FILE is an FBX, Collada or Blender file, or any other that Blender reads; OUTPUT ends in .usd, .usda or .usdc.
    Meshes, skeletons, blend shapes and curves are written as they move, in all frames with keys; materials and lights
    are not. Blender runs in the background: the module bpy, or the program blender in the PATH. No script in a .blend
    file is run.
    """
    from hairpipe.formats.blender import convert

    check_plain(file, "a file that Blender reads")
    check_plain(output, "a USD file")
    convert(file, output)
    click.echo(output)
