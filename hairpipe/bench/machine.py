"""The machine: its processor, its cores, and the versions of what makes machine code."""

import importlib.metadata
import os
import platform
import subprocess
from pathlib import Path
from typing import NamedTuple

from hairpipe import __version__

_COMPILERS = ("numpy", "numba", "llvmlite")


class Machine(NamedTuple):
    """A machine.

    processor  its model
    cores      that the system counts
    versions   by name
    """

    processor: str
    cores: int
    versions: dict[str, str]


def this_machine() -> Machine:
    """Describe the machine at hand."""
    versions = {"hairpipe": __version__, "python": platform.python_version()}
    versions |= {name: importlib.metadata.version(name) for name in _COMPILERS}
    return Machine(_processor(), os.cpu_count() or 1, versions)


def commit() -> str:
    """Name the commit of the code at hand, and whether it was changed since; where there is no repository, the version.

    It is that of the folder which holds this package.
    """
    folder = Path(__file__).resolve().parents[2]
    git = ["git", "-C", str(folder)]
    try:
        name, changes = (
            subprocess.run([*git, *words], capture_output=True, text=True, check=True, timeout=60).stdout.strip()
            for words in (("rev-parse", "--short=7", "HEAD"), ("status", "--porcelain", "--untracked-files=no"))
        )
    except (OSError, subprocess.SubprocessError):
        return f"of version {__version__}"
    return f"{name} with changes" if changes else name


def _processor() -> str:
    """Name the processor; Linux says it in a file."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
