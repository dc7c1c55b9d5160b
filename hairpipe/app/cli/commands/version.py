"""`hairpipe version`: versions of the software that results depend on."""

import importlib.metadata
import json
import os
import platform

import click

from hairpipe import __version__
from hairpipe.app.api.formatting import table
from hairpipe.app.cli import options
from hairpipe.engine.worker.threading_layer import choose_layer
from hairpipe.processor import processor_class

DISTRIBUTIONS = {
    "numpy": "numpy",
    "scipy": "scipy",
    "numba": "numba",
    "usd": "usd-core",
    "h5py": "h5py",
    "blosc": "blosc",
}


@click.command()
@options.as_json
def version(as_json: bool) -> None:
    """Print versions, cores, class of processor and threading layer."""
    from hairpipe.openvdb_library import version_of_openvdb

    found: dict[str, str | int | None] = {"hairpipe": __version__, "python": platform.python_version()}
    found |= {name: version_of(distribution) for name, distribution in DISTRIBUTIONS.items()}
    found |= {"openvdb": version_of_openvdb()}
    found |= {"threads": os.cpu_count(), "class": processor_class(), "threading layer": choose_layer().name}
    if as_json:
        click.echo(json.dumps(found, indent=2))
    else:
        click.echo(
            table([(name, "not installed" if value is None else str(value)) for name, value in found.items()], "<<")
        )


def version_of(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None
