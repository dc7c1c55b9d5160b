"""The benches `machines` and `parity`: faults while several machines compute a shot, and equal results by every way."""

import sys

import click

from hairpipe.app.cli import options
from hairpipe.app.cli.stderr import echo
from hairpipe.graphs.experiments.commands.measured import print_report, record


@click.command()
@click.option("--only", metavar="TEXT", default="", help="Part of the names of the faults to try; by default all.")
@options.as_json
@record
def machines(only: str, as_json: bool) -> None:
    """Test runs on several machines against faults: processes killed and stopped, machines that differ, a full store.

    A toy shot of 18 evaluations is computed on this machine, or on a Dask cluster of two machines on loopback, which
    are processes with homes of their own. The fault strikes while a certain evaluation is held; a run that ends with
    another exit code than 0 is repeated. In the end all results, objects and published files must be those of an
    undisturbed run, no more must have been evaluated again than was lost, and each fault must be one line. A store is
    filled where this user may mount a file system. It takes a quarter of an hour.

    Exit code 0: all as required, 1: not all.
    """
    from hairpipe.formats.hdf5 import digest_file
    from hairpipe.graphs.experiments.bench.machines.fault_list import FAULTS
    from hairpipe.graphs.experiments.bench.machines.trials import held, try_machines

    report = try_machines(echo, digest_file, [fault for fault in FAULTS if only in fault.title])
    print_report(report, as_json)
    sys.exit(0 if held(report) else 1)


@click.command()
@options.as_json
@record
def parity(as_json: bool) -> None:
    """Compute one wedge in four ways, and compare bytes and numbers of evaluations.

    The wedge `sixteen` of graphs/wedges/tuft.toml, 24 frames: by one run, by a run on a Dask cluster of two machines on
    loopback with homes and kernels of their own, as a job of Open Job Description by `openjd run`, and by its commands
    in a random order. Each way has a store and publishes files of its own. It takes a quarter of an hour.

    Exit code 0: all are equal, 1: some differ.
    """
    from hairpipe.formats.hdf5 import digest_file
    from hairpipe.graphs.experiments.bench.machines.parity import GRAPH, agree, compare_ways

    report = compare_ways(echo, digest_file)
    print_report(report, as_json, [GRAPH])
    sys.exit(0 if agree(report) else 1)
