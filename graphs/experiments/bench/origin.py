"""Origin of figures, as written above a table: commit, machine and command."""

import shlex
import subprocess
from collections.abc import Sequence
from pathlib import Path

from hairpipe import __version__
from hairpipe.app.api.formatting import plural


def origin(command: Sequence[str]) -> str:
    """Describe the origin of figures of a command, given by its words."""
    from hairpipe.graphs.experiments.bench.machine import this_machine

    machine = this_machine()
    where = f"{plural(machine.cores, 'core')}, {machine.processor}"
    return f"commit {commit()}; machine {where}; command `{shlex.join(command)}`"


def commit() -> str:
    """Name the commit of the code, and whether the code has changed since; without a repository, the version.

    It is that of the folder which holds this package.
    """
    git = ["git", "-C", str(Path(__file__).resolve().parents[3])]
    try:
        name, changes = (
            subprocess.run([*git, *words], capture_output=True, text=True, check=True, timeout=60).stdout.strip()
            for words in (("rev-parse", "--short=7", "HEAD"), ("status", "--porcelain", "--untracked-files=no"))
        )
    except (OSError, subprocess.SubprocessError):
        return f"of version {__version__}"
    return f"{name} with changes" if changes else name
