"""The benches `calls` and `schedules`: a fault at every call of the file system, and two coordinators in any order."""

import sys

import click

from hairpipe.app.cli import options
from hairpipe.app.cli.stderr import echo
from hairpipe.graphs.experiments.commands.measured import print_report, record


@click.command()
@click.option("--every", type=click.IntRange(min=1), default=1, show_default=True, help="Try each n-th call only.")
@options.as_json
@record
def calls(every: int, as_json: bool) -> None:
    """Test a run against a fault at each of its calls of the file system, in turn.

    A toy shot of four frames is computed by simulated processes in this one. In one run after another, one call on the
    store or on published files fails, or the process is killed before it, or the power fails, so that files which were
    not flushed lose their second half. The next run must end with the results, objects and published files of an
    undisturbed run, evaluate no more than was lost, and leave no temporary file and no lease. A failed call must have
    no effect or be one message. It takes half an hour.

    Exit code 0: all as required, 1: not all.
    """
    from hairpipe.formats.hdf5 import digest_file
    from hairpipe.graphs.experiments.bench.calls.call_trials import held, try_calls

    report = try_calls(echo, digest_file, every)
    print_report(report, as_json)
    sys.exit(0 if held(report) else 1)


@click.command()
@click.option("--seeds", type=click.IntRange(min=1), default=1000, show_default=True, help="Number of schedules.")
@click.option("--first", type=click.IntRange(min=0), default=0, show_default=True, help="Smallest of the seeds.")
@options.as_json
@record
def schedules(seeds: int, first: int, as_json: bool) -> None:
    """Test two coordinators of one shot, which take turns at calls of the file system in random order.

    A seed gives the whole schedule. In half of the schedules one of the two is killed at some call. Nothing may be
    evaluated twice but what was lost by the kill, and results, objects and published files must be those of an
    undisturbed run. A thousand schedules take two minutes.

    Exit code 0: all as required, 1: not all.
    """
    from hairpipe.formats.hdf5 import digest_file
    from hairpipe.graphs.experiments.bench.calls.call_trials import held
    from hairpipe.graphs.experiments.bench.calls.schedules import try_schedules

    report = try_schedules(echo, digest_file, range(first, first + seeds))
    print_report(report, as_json)
    sys.exit(0 if held(report) else 1)
