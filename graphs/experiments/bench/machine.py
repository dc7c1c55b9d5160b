"""The machine: its processor, its cores, and the versions of compilers."""

import importlib.metadata
import os
import platform
from pathlib import Path
from typing import NamedTuple

from hairpipe import __version__
from hairpipe.engine.worker.machine_code import share_kernels
from hairpipe.engine.worker.threading_layer import choose_layer

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
    """Name the processor, from a file of Linux; family and model, since a virtual machine may hide the generation."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    fields: dict[str, str] = {}
    for line in reversed(lines):  # the first processor is the last that counts
        key, _, value = line.partition(":")
        fields[key.strip()] = value.strip()
    if "model name" not in fields:
        return platform.processor() or platform.machine()
    generation = {"family": "cpu family", "model": "model"}
    words = [f"{word} {fields[key]}" for word, key in generation.items() if key in fields]
    return " ".join([fields["model name"], *words])
