"""The machine: its processor, its cores, and the versions of compilers."""

import importlib.metadata
import os
import platform
from pathlib import Path
from typing import NamedTuple

from hairpipe import __version__
from hairpipe.graph.worker.machine_code import share_kernels
from hairpipe.graph.worker.threading_layer import choose_layer

__all__ = ["Machine", "share_kernels", "this_machine"]

_COMPILERS = ("numpy", "numba", "llvmlite")


class Machine(NamedTuple):
    """A machine.

    processor  model
    cores      number of logical cores
    versions   by name, with the threading layer of numba
    """

    processor: str
    cores: int
    versions: dict[str, str]


def this_machine() -> Machine:
    """Describe this machine."""
    versions = {"hairpipe": __version__, "python": platform.python_version()}
    versions["threading layer"] = choose_layer().name
    versions |= {name: importlib.metadata.version(name) for name in _COMPILERS}
    return Machine(_processor(), os.cpu_count() or 1, versions)


def _processor() -> str:
    """Return the model of the processor, from a file of Linux."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
