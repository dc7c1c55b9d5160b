"""Work on a foreign file in a process of its own, because a damaged one can crash OpenUSD.

Of 1 000 crate files with one to four bytes changed thirteen ended the process with a segmentation fault, and so does a
text file of 200 000 nested prims; others have it fill all memory there is. No check of the header foresees it.
"""

import importlib
import os
import resource
import signal
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from hairpipe.child import command, environment
from hairpipe.errors import BadInput
from hairpipe.io.usd.wire import pack, unpack

MEMORY = 4 << 30  # bytes: far more than a frame of any shot, and OpenUSD says no to a damaged count beyond it
Result = TypeVar("Result")


def work_apart(work: Callable[..., Result], path: Path, *arguments: Any) -> Result:
    """Return `work(path, *arguments)`, done in a child process; its warnings and BadInput come through.

    work  a function of a module; its arguments and result are values that `wire` knows

    Raises BadInput where the work does, or when the process dies of the file.
    """
    child = subprocess.run(
        command(f"from {__name__} import serve; serve()"),
        input=pack((work.__module__, work.__name__, path, arguments)),
        capture_output=True,
        env=environment(),
    )
    if child.returncode < 0:
        cause = signal.Signals(-child.returncode).name
        raise BadInput(f"OpenUSD breaks down reading it ({cause})", where=path, right="a file that is not damaged")
    if child.returncode > 0:
        raise RuntimeError(f"{work.__module__}.{work.__name__} failed:\n{child.stderr.decode(errors='replace')}")
    result, warned = unpack(child.stdout)
    for warning in warned:
        warnings.warn(warning, UserWarning, stacklevel=2)
    if isinstance(result, BadInput):
        raise result
    return result


def limit_memory() -> int:
    """Let this process have no more than MEMORY of its own, or less where it may not; return how much [bytes].

    Mapped files are not counted.
    """
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most = MEMORY if hard == resource.RLIM_INFINITY else min(MEMORY, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    return most


def serve() -> None:
    """Do the work that stands on standard input, and write what came of it to standard output."""
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints must not end up in the answer
        module, name, path, arguments = unpack(sys.stdin.buffer.read())
        work = getattr(importlib.import_module(module), name)
        most = limit_memory()
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always", UserWarning)
            try:
                result = work(path, *arguments)
            except BadInput as fault:
                result = fault
            except MemoryError:
                what = f"takes more than {most / 2**30:.2g} GiB of memory"
                result = BadInput(what, where=path, right="a smaller file")
        out.write(pack((result, [str(w.message) for w in warned if w.category is UserWarning])))
