"""A process of its own with this Python: it finds modules where this one does, and never in the current folder.

Python looks there with -c and -m, and wherever an entry of PYTHONPATH is empty, as `$PYTHONPATH:lib` often begins. But
one works in folders that are strangers', and a `json.py` next to a graph is not ours to run.
"""

import ctypes
import json
import os
import resource
import signal
import sys
import time
from contextlib import suppress

PR_SET_PDEATHSIG = 1

withheld: list[str] = []
"""Entries of sys.path that children are not given: folders of nodes, which whoever needs one enters by himself."""


def command(code: str) -> list[str]:
    """Command line of a child that carries out a line of Python."""
    boot = f"import sys, json; sys.path[:] = json.loads(sys.argv.pop()); {code}"
    return [sys.executable, "-P", "-c", boot, json.dumps(search_path())]


def environment() -> dict[str, str]:
    """Environment of a child: ours, and nothing in it that stands for the current folder without naming it."""
    given = os.environ.get("PYTHONPATH")
    return os.environ | (
        {} if given is None else {"PYTHONPATH": os.pathsep.join(filter(None, given.split(os.pathsep)))}
    )


def search_path() -> list[str]:
    """Return the module path of child processes: that of this one, without withheld folders and the current folder."""
    given = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    left_out = {"", *withheld}
    with suppress(FileNotFoundError):  # of a current folder that is gone nothing can be imported
        here = os.path.abspath("")  # noqa: PTH100 - as Python made it, links and all
        if len(given) > 1 and "" in given and here not in map(os.path.abspath, filter(None, given)):
            left_out.add(here)
    return [entry for entry in sys.path if entry not in left_out]


def die_with_parent() -> None:
    """Ask Linux to kill this process when its parent ends; elsewhere it may notice that a pipe is closed."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


_counted = [0.0]
"""Processor time of children that have not ended [s]."""


def count_time(seconds: float) -> None:
    """Add processor time of a child that has not ended [s]."""
    _counted[0] += seconds


def processor_time() -> float:
    """Processor time of this process, of its children that have ended, and of the works of others [s]."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime + _counted[0]
