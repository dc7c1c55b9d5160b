"""`hairpipe workers`: idle workers that `hairpipe run --keep` has kept."""

import json

import click

from hairpipe.app.cli import options


@click.command()
@click.option("--end", is_flag=True, help="End the idle workers.")
@options.as_json
def workers(end: bool, as_json: bool) -> None:
    """List or end the idle workers of earlier runs.

    The option `keep` of `hairpipe run` keeps workers for the next run. They end ten minutes after the last run with
    this option, and a run with other code, versions or environment variables starts new ones.
    """
    from hairpipe.app.api.formatting import duration, plural
    from hairpipe.app.api.workers import end_workers, kept_workers

    if end:
        count = end_workers()
        click.echo(json.dumps({"ended": count}) if as_json else f"{plural(count, 'worker')} ended")
        return
    found = [(count, left) for count, left in kept_workers() if count]
    if as_json:
        click.echo(json.dumps({"kept": [{"workers": count, "left": left} for count, left in found]}, indent=2))
    else:
        lines = [f"{plural(count, 'idle worker')}, for {duration(left)} more" for count, left in found]
        click.echo("\n".join(lines or ["no idle workers"]))
