"""Processes that stand for machines: each has a home, temporary files and kernels of its own.

A prelude is Python that such a process carries out first; it makes the process differ from the machine that it is.
"""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from hairpipe.child import command, environment
from hairpipe.engine.file.trust import VARIABLE
from hairpipe.errors import BadInput

PATIENCE = 240.0
"""Time within which a process must have started, or ended [s]."""
FOLDERS = ("HOME", "TMPDIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME", "NUMBA_CACHE_DIR")
"""Variables of the environment that name a home, and what lies in it by default."""
MORTAL = "from hairpipe.child import die_with_parent; die_with_parent()"
NO_KERNELS = "from hairpipe.engine.worker import machine_code\nmachine_code.kernel_modules = lambda: iter(())"
"""Prelude for nodes without kernels: those of hairpipe are not analysed, which takes seconds with every new store."""
COMMAND_LINE = "from hairpipe.cli import main; sys.argv[1:] = {!r}; main()"


class Machine(NamedTuple):
    """What a process believes of the machine that it runs on.

    prelude    carried out first
    variables  of its environment
    """

    prelude: str = ""
    variables: Mapping[str, str] = {}


class Started:
    """A process in a group of its own, and its standard error."""

    def __init__(self, code: str, home: Path, machine: Machine, variables: Mapping[str, str]) -> None:
        home.mkdir(parents=True, exist_ok=True)
        self.log = home / "log"
        self.output = home / "output"
        lines = "\n".join(line for line in (machine.prelude, MORTAL, code) if line)
        given = {**environment(), **dict.fromkeys(FOLDERS, str(home)), **variables, **machine.variables}
        with self.log.open("wb") as log, self.output.open("wb") as output:
            self.process = subprocess.Popen(
                command(lines), cwd=home, env=given, stdout=output, stderr=log, start_new_session=True
            )

    @property
    def text(self) -> str:
        """What it has written to standard error so far."""
        return self.log.read_text(errors="replace")

    def wait(self, limit: float = PATIENCE) -> int | None:
        """Wait for the end; returns the exit code, or None where it does not end in time."""
        with suppress(subprocess.TimeoutExpired):
            return self.process.wait(limit)
        return None

    def end(self) -> None:
        """Kill the group."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()


def start_command(words: list[str], home: Path, machine: Machine, variables: Mapping[str, str]) -> Started:
    """Start the command line with these words."""
    return Started(COMMAND_LINE.format(words), home, machine, variables)


def without_trust() -> dict[str, str]:
    """Return variables that take back the trust which this process has inherited; pure."""
    return {VARIABLE: ""}


def wait_for(condition: Callable[[], object], what: str, limit: float = PATIENCE) -> None:
    """Wait until a condition holds; BadInput where it does not in time.

    what  is waited for
    """
    end = time.monotonic() + limit
    while not condition():
        if time.monotonic() > end:
            raise BadInput(f"waited {limit:g} s for {what}")
        time.sleep(0.05)
