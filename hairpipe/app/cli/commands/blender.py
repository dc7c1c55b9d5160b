"""`hairpipe blender`: a shot in Blender."""

from pathlib import Path

import click

from hairpipe.plain_file import check_plain


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Blender file to save, .blend.")
@click.option("--picture", type=click.Path(path_type=Path), help="Picture of the first frame to render, .png or .webp.")
def blender(file: Path, output: Path | None, picture: Path | None) -> None:
    """Import a USD shot into Blender.

    Hair gets a material; body, level sets and frame range are those of the shot. With -o or --picture Blender runs in
    the background. Without, the script is printed, for Blender's text editor, or to start Blender with it.
    """
    from hairpipe.formats.blender import make_scene, script_of

    check_plain(file, "a USD file")
    if output is None and picture is None:
        click.echo(script_of(file), nl=False)
        return
    for path, suffixes in ((output, (".blend",)), (picture, (".png", ".webp"))):
        if path is not None:
            if path.suffix.lower() not in suffixes:
                raise click.UsageError(f"{path}: a file that ends in {' or '.join(suffixes)} is needed")
            check_plain(path, f"a {path.suffix} file")
            path.parent.mkdir(parents=True, exist_ok=True)
    make_scene(file, output, picture)
    for path in (output, picture):
        if path is not None:
            click.echo(path)
