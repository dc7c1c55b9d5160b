"""Other programs and their files: JSON lines, a shot in Blender, conversion to USD, and checks of USD files."""

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hairpipe.app.cli import options
from hairpipe.app.cli.stderr import echo
from hairpipe.engine.node.messages import one_line
from hairpipe.plain_file import check_plain

if TYPE_CHECKING:
    from hairpipe.formats.usd.check.scene import Finding

PROGRAMS = ("unreal", "houdini", "blender", "karma", "storm", "renderman", "moonray")
"""Programs with rules of their own."""


@click.command()
def bridge() -> None:
    """Serve another program by JSON lines on the standard streams.

    The program writes requests, such as {"id": 1, "do": "run", "graph": "shot.toml"}, and reads events: progress,
    frames, failures. The end of the input cancels a run and ends the command; computed results are kept. The reference
    of the protocol is in the documentation.
    """
    from hairpipe.app.bridge import main
    from hairpipe.child import die_with_parent

    die_with_parent()
    main()


@click.command()
@click.argument("file", type=click.Path(path_type=Path), required=False)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Blender file to save, .blend; or .zip.")
@click.option("--picture", type=click.Path(path_type=Path), help="Picture of the first frame to render, .png or .webp.")
@click.option("--simulate", "hair", metavar="HAIR", help="Name of a hair object of FILE, a .blend file, to simulate.")
@click.option("--extension", is_flag=True, help="Write the extension for Blender, which simulates hair of a scene.")
def blender(file: Path | None, output: Path | None, picture: Path | None, hair: str | None, extension: bool) -> None:
    """Import a shot into Blender, or simulate the hair of a scene.

    FILE is a USD shot: hair gets a material; body, level sets and frame range are those of the shot. With -o or
    --picture Blender runs in the background. Without, the script is printed, for Blender's text editor, or to start
    Blender with it.

    With --simulate FILE is a .blend file, whose hair is simulated as by the extension; with -o it is saved with the
    result. No script in it is run. With --extension -o hairpipe.zip the extension is written.
    """
    from hairpipe.app.api.node_types import describe
    from hairpipe.blender import programs

    def path_of(path: Path, *suffixes: str) -> Path:
        if path.suffix.lower() not in suffixes:
            raise click.UsageError(f"{path}: a file that ends in {' or '.join(suffixes)} is needed")
        check_plain(path, f"a {path.suffix} file")
        path.parent.mkdir(parents=True, exist_ok=True)
        return path

    if extension:
        from hairpipe.blender.extension_zip import write_extension

        if file or picture or hair or output is None:
            raise click.UsageError("--extension takes -o FILE.zip, and nothing else")
        write_extension(path_of(output, ".zip"), describe)
        click.echo(output)
        return
    if file is None:
        raise click.UsageError("Missing argument 'FILE': a USD shot, or a .blend file with --simulate.")
    check_plain(file, "a Blender file" if hair else "a USD file")
    made = [path_of(path, *ends) for path, ends in ((output, (".blend",)), (picture, (".png", ".webp"))) if path]
    if hair is not None:
        if picture:
            raise click.UsageError("--simulate and --picture exclude each other")
        programs.simulate(file, hair, output, describe, echo)
    elif made:
        programs.make_scene(file, output, picture)
    else:
        click.echo(programs.script_of(file), nl=False)
    for path in made:
        click.echo(path)


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
    from hairpipe.blender.programs import convert

    check_plain(file, "a file that Blender reads")
    check_plain(output, "a USD file")
    convert(file, output)
    click.echo(output)


@click.group()
def usd() -> None:
    """Check USD files."""


@usd.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--for",
    "programs",
    type=click.Choice([*PROGRAMS, "all"]),
    multiple=True,
    help="Program that reads the file, with rules of its own, and what it does not show. May be repeated.",
)
@click.option("--since", type=click.Path(path_type=Path), help="Earlier version of FILE; differences are listed.")
@options.as_json
def check(file: Path, programs: tuple[str, ...], since: Path | None, as_json: bool) -> None:
    """Check a shot and its OpenVDB files, more strictly than OpenUSD does.

    The validators of OpenUSD run first, then rules for hair. Each finding is a line: severity, rule, path @ time,
    fault. If `export_usd` has written FILE, the line ends with the settings of the graph that caused it, and what to
    write there. Errors and warnings are faults; `change` is a difference from --since, `note` what a program does not
    show.

    Exit code 0: no faults, 1: faults, 2: a file cannot be read.
    """
    from hairpipe.apart import work_apart

    check_plain(file, "a USD file")
    if since is not None:
        check_plain(since, "a USD file")
    findings = work_apart(lint_file, file, PROGRAMS if "all" in programs else programs, since)
    if as_json:
        click.echo(json.dumps({"file": str(file), "findings": [asdict(finding) for finding in findings]}, indent=2))
    else:
        for finding in findings:
            click.echo(one_line(str(finding)))
    sys.exit(1 if any(finding.severity in ("error", "warning") for finding in findings) else 0)


def lint_file(file: Path, programs: Sequence[str] = (), since: Path | None = None) -> "list[Finding]":
    from hairpipe.formats.usd.check.changes import compare
    from hairpipe.formats.usd.check.lint import lint
    from hairpipe.formats.vdb import inspect

    return [*lint(file, inspect, programs), *([] if since is None else compare(file, since))]
