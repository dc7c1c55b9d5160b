"""The benches `promises` and `needs`: whether `tune` keeps what it promises, and what scenes need."""

import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

import hairpipe
from hairpipe.app.api.formatting import markdown, table
from hairpipe.app.cli import options
from hairpipe.app.cli.commands.tune import INTERRUPTED, runner
from hairpipe.app.cli.stderr import echo
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.origin import origin

if TYPE_CHECKING:
    from hairpipe.app.tune.measured import Tolerance

PROGRAM = ("python", "-m", "hairpipe.graphs.experiments.bench")
"""What starts a bench, word by word."""
SIX = (
    "tune/short_slow",
    "paper/long_straight_5000",
    "paper/long_curly",
    "paper/medium_straight_wind",
    "tune/long_spin",
    "paper/hundred_thousand_25",
)
"""Scenes of six kinds: short, long and straight, curls, wind, a spin, and as many hairs as a head has."""


def read_numbers(ctx: click.Context, param: click.Parameter, text: str) -> tuple[int, ...]:
    """Read numbers of scenes, written as frames are."""
    try:
        return options.read_frames(ctx, param, text) or ()
    except BadInput as fault:
        raise BadInput(fault.what, where="--scenes", right="1-20, or 3,7") from None


def read_tolerances(ctx: click.Context, param: click.Parameter, texts: tuple[str, ...]) -> "list[Tolerance]":
    """Read lengths and percentages."""
    from hairpipe.app.tune.measured import read_tolerance

    return [read_tolerance(text) for text in texts]


@click.command()
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of all random scenes.")
@click.option(
    "--scenes",
    "numbers",
    metavar="1-20",
    default="1-20",
    show_default=True,
    callback=read_numbers,
    help="Range of scene numbers.",
)
@options.side_by_side
@options.cache
@options.as_markdown
@options.as_json
def promises(
    seed: int,
    numbers: tuple[int, ...],
    engine: options.Engine,
    cache: Path,
    as_markdown: bool,
    as_json: bool,
) -> None:
    """Try the promises of `hairpipe tune` on scenes that are drawn at random.

    Each scene, of a few hundred hairs, is tuned to a tolerance; what was chosen, and passed the check, is then compared
    with a reference on strands or frames of neither, and in another motion. As nine in ten are promised, so many should
    be kept. Where the other motion is harder than those that the promise holds for, only the first counts.

    All is cached: the same command, given again, computes nothing, and goes on where it was stopped. Simulations of a
    scene run side by side, see `hairpipe tune`.
    """
    from hairpipe.app.api.source import shipped_graphs
    from hairpipe.graphs.experiments.scenes import promises as trying
    from hairpipe.graphs.experiments.scenes.drawing import draw_scene
    from hairpipe.graphs.experiments.scenes.pace import Pace

    drawn = {number: draw_scene(seed, number) for number in numbers}
    base = hairpipe.load(drawn[numbers[0]].tables, cache=cache, folder=shipped_graphs()["demo"].parent)
    pace = Pace(len(drawn), lambda: runner(engine, quiet=False), echo)
    found = []
    with ending_where_interrupted(), base.keeping_workers() as shot:
        for number, scene in drawn.items():
            with pace.scene(f"scene {number}: {scene.text}"):
                found.append(trying.try_promise(shot, number, scene, pace.run, echo))
    if as_json:
        click.echo(json.dumps(trying.document(found), indent=2))
        return
    words = [*PROGRAM, "promises", "--seed", str(seed), "--scenes", ",".join(map(str, numbers))]
    show(trying.rows(found), trying.ALIGN, words if as_markdown else None)
    click.echo("\n" + "\n".join(f"- {line}" for line in trying.summary(found)))


@click.command()
@options.graphs
@click.option("--node", default="hair", show_default=True, metavar="NODE", help="Node of the simulation in each graph.")
@click.option(
    "--tolerance",
    "tolerances",
    multiple=True,
    default=("1%", "3%", "10%"),
    show_default=True,
    metavar="2mm|0.5%",
    callback=read_tolerances,
    help="Tolerance, as for `hairpipe tune`; repeatable.",
)
@options.overrides
@options.side_by_side
@options.cache
@options.as_markdown
@options.as_json
def needs(
    graphs: tuple[str, ...],
    node: str,
    tolerances: "list[Tolerance]",
    overrides: dict[str, str],
    engine: options.Engine,
    cache: Path,
    as_markdown: bool,
    as_json: bool,
) -> None:
    """List what scenes need: the cheapest model for some tolerances, as `hairpipe tune` finds it.

    Without a GRAPH, scenes of six kinds: short hair, long straight hair, curls, wind, a spin, 100,000 hairs.
    """
    from hairpipe.graphs.experiments.scenes import needs as needed
    from hairpipe.graphs.experiments.scenes.pace import Pace

    given = graphs or SIX
    shots = {Path(graph).stem: hairpipe.load(graph, options.parsed(overrides), cache=cache) for graph in given}
    pace = Pace(len(shots) * len(tolerances), lambda: runner(engine, quiet=False), echo)
    with ending_where_interrupted():
        found = list(needed.needs_of(shots, node, tolerances, pace, echo))
    if as_json:
        click.echo(json.dumps(needed.document(found), indent=2))
        return
    words = [*PROGRAM, "needs", *graphs, *(["--node", node] if node != "hair" else [])]
    words += [word for tolerance in tolerances for word in ("--tolerance", str(tolerance).replace(" ", ""))]
    words += [word for pair in overrides.items() for word in ("--set", "=".join(pair))]
    show(needed.rows(found), needed.ALIGN, words if as_markdown else None)


@contextmanager
def ending_where_interrupted() -> Iterator[None]:
    """End with the code of an interruption, and a word about what is kept."""
    from hairpipe.app.tune.study import Interrupted

    try:
        yield
    except Interrupted:
        echo("hairpipe: interrupted; measurements are kept, and the same command resumes")
        sys.exit(INTERRUPTED)


def show(rows: Sequence[tuple[str, ...]], align: str, words: Sequence[str] | None) -> None:
    """Write a table; with the words of a command as Markdown, below where its figures come from."""
    if words is None:
        click.echo(table(rows, align))
        return
    click.echo(f"{origin(words)}\n\n{markdown(rows, align)}")
