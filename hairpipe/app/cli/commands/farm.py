"""`hairpipe farm`: hand a shot over to a farm."""

from pathlib import Path

import click

import hairpipe
from hairpipe.app.cli import options


@click.command()
@options.graph
@options.frames
@options.overrides
@options.wedge
@click.option("--chunk", type=click.IntRange(min=1), default=10, show_default=True, help="Number of frames of a task.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["openjd", "commands"]),
    default="openjd",
    show_default=True,
    help="Format of the job: openjd (job.json, Open Job Description), commands (commands.txt, one a line).",
)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FOLDER", required=True, help="Folder for the job."
)
@options.cache
def farm(
    graph: str,
    frames: tuple[int, ...] | None,
    overrides: dict[str, str],
    wedge: str | None,
    chunk: int,
    form: str,
    output: Path,
    cache: Path,
) -> None:
    """Write the commands that compute a shot in parts, for a farm. Nothing is computed.

    The parts are values for the shot, frames that need no simulation, simulations (a task each), frames that need
    them, and files of all frames. Of a wedge, what the variants share comes first, then a task for each variant, or for
    its frames. The order saves time and changes no result: a task computes whatever it needs that
    is not in the cache, which all machines share. A task ends with exit code 0 where all that it was asked for is
    computed, and with 75 where another one still computes it: run it again.
    """
    from hairpipe.app.farm import FORMATS, build_steps
    from hairpipe.engine.store.atomic import write_text

    shot = hairpipe.load(graph, options.parsed(overrides), cache=cache)
    chosen = shot if wedge is None else shot.wedge(wedge)
    common = [word for name, value in overrides.items() for word in ("--set", f"{name}={value}")]
    common += [] if wedge is None else ["--wedge", wedge]
    steps = build_steps(chosen.levels(), chosen.graph.select(frames), chunk, common)
    name, write = FORMATS[form]
    path = Path(graph)
    text = write(steps, str(path.absolute()) if path.exists() else graph, cache.absolute())
    write_text(output / name, text)
    tasks = sum(map(len, steps))
    click.echo(f"{output / name}: {tasks} tasks in {len(steps)} steps")
