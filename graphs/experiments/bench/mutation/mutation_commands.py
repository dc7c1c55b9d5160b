"""The bench `mutate`: how many small changes of the engine and of the laws their tests notice."""

from pathlib import Path

import click

from hairpipe.app.cli import options
from hairpipe.app.cli.stderr import echo
from hairpipe.graphs.experiments.commands.measured import print_report, record

ROOMS = ("key", "store", "run", "laws")


@click.command()
@click.option(
    "--room",
    type=click.Choice(ROOMS),
    multiple=True,
    help="Part of the engine, or laws; repeatable; by default all.",
)
@click.option(
    "--most", type=click.IntRange(min=1), default=80, show_default=True, help="Largest number of mutations a room."
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the choice of mutations.")
@click.option(
    "--known",
    type=click.Path(path_type=Path, dir_okay=False),
    help="File of earlier outcomes, to which this run adds; killed mutations are not tried again.",
)
@options.as_json
@record
def mutate(room: tuple[str, ...], most: int, seed: int, known: Path | None, as_json: bool) -> None:
    """Measure the mutation score of the engine and of the laws: the share of small changes that fail a test.

    Mutations are those of Cosmic Ray, statements left out, and None returned: one for each place, and of the places a
    sample. Each is tried in a copy of the checkout with the tests of its file, until one fails. `first` is the score
    of the earliest outcomes in the file of `--known`. It takes an hour, in one process. Cosmic Ray is in the extra
    `mutation`.
    """
    from hairpipe.graphs.experiments.bench.mutation.mutation_trials import mutated_files, try_mutations

    rooms = room or ROOMS
    print_report(try_mutations(echo, rooms, most, seed, known), as_json, mutated_files(rooms))
