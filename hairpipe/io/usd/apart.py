"""Work on a foreign file in a child process, because a damaged one can crash OpenUSD.

Of 1 000 crate files with one to four bytes changed thirteen ended the process with a segmentation fault, and so does a
text file of 200 000 nested prims; others fill all memory, as 2 kB of references that double at each level, or compute
without end. No check of the header detects these, so that memory and time are limited.
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
from typing import TYPE_CHECKING, Any, TypeVar

from hairpipe.child import command, die_with_parent, environment
from hairpipe.errors import BadInput
from hairpipe.io.usd.wire import pack, unpack

if TYPE_CHECKING:
    from hairpipe.io.usd.layer_files import Layers

MEMORY = 4 << 30  # bytes: far more than a frame of any shot; OpenUSD refuses a damaged count beyond it
# Of processor time, and bytes of layers for each second more: ten times as long as a lint takes.
SECONDS, RATE = 60, 1e6
PATIENCE = 10  # wall-clock time over processor time, for busy computers
ONE_THREAD = {"PXR_WORK_THREAD_LIMIT": "1"}
"""Environment of a child: a thread of OpenUSD without memory may end by a segmentation fault."""
OVERDUE = (signal.SIGXCPU, signal.SIGALRM)
Result = TypeVar("Result")


def work_apart(work: Callable[..., Result], path: Path, *arguments: Any) -> Result:
    """Return `work(path, *arguments)`, done in a child process, with its warnings and BadInput.

    work  a function of a module; its arguments and result are values that `wire` supports

    Raises BadInput where the work does, or when the process crashes or exceeds its limits of memory and time.
    """
    child = subprocess.run(
        command(f"from {__name__} import serve; serve()"),
        input=pack((work.__module__, work.__name__, path, arguments)),
        capture_output=True,
        env=environment() | ONE_THREAD,
    )
    if child.returncode < 0:
        raise _death(child, path)
    if child.returncode > 0:
        raise RuntimeError(f"{work.__module__}.{work.__name__} failed:\n{child.stderr.decode(errors='replace')}")
    result, warned = unpack(child.stdout)
    for warning in warned:
        warnings.warn(warning, UserWarning, stacklevel=2)
    if isinstance(result, BadInput):
        raise result
    return result


def _death(child: subprocess.CompletedProcess[bytes], path: Path) -> BadInput:
    """Return why a signal has ended a child."""
    if -child.returncode in OVERDUE:
        what = f"takes more than {SECONDS} s of processor time, and {1e6 / RATE:g} s per MB of its layers"
        return BadInput(what, where=path, right="fewer nested references or instances")
    if b"bad_alloc" in child.stderr:
        return _too_large(path, most_memory())
    cause = signal.Signals(-child.returncode).name
    return BadInput(f"OpenUSD fails to read the file ({cause})", where=path, right="a file that is not damaged")


def _too_large(path: Path, most: int) -> BadInput:
    return BadInput(f"takes more than {most / 2**30:.2g} GiB of memory", where=path, right="a smaller file")


def most_memory() -> int:
    """Return the memory limit of a child [bytes]: MEMORY, or the lower limit of this process."""
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    return MEMORY if hard == resource.RLIM_INFINITY else min(MEMORY, hard)


def limit_memory() -> int:
    """Limit the memory of this process, without mapped files, to `most_memory`; return that [bytes]."""
    most = most_memory()
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    return most


def limit_time(size: int, own: int) -> None:
    """Set the processor time limit of this process.

    size  of the layers [bytes]
    own   limit of processor time that the caller has set [s], or RLIM_INFINITY
    """
    seconds = SECONDS + int(size / RATE)
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    # The system sends SIGKILL at the hard limit, without a message.
    limits = [seconds, *(limit for limit in (own, hard - 1) if limit >= 0)]
    resource.setrlimit(resource.RLIMIT_CPU, (min(limits), hard))
    signal.alarm(PATIENCE * seconds)


def serve() -> None:
    """Read the work from standard input, do it, and write the result to standard output."""
    die_with_parent()
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # prints of a library must not be part of the answer
        module, name, path, arguments = unpack(sys.stdin.buffer.read())
        work = getattr(importlib.import_module(module), name)
        most = limit_memory()
        own, _ = resource.getrlimit(resource.RLIMIT_CPU)
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always", UserWarning)
            try:
                limit_time(0, own)
                layers = layers_of(path)  # open until the work is done
                limit_time(layers.bytes if layers else 0, own)
                result = work(path, *arguments)
            except BadInput as fault:
                result = fault
            except MemoryError:
                result = _too_large(path, most)
        out.write(pack((result, [str(w.message) for w in warned if w.category is UserWarning])))


def layers_of(path: object) -> "Layers | None":
    """Open the layers of a stage; None for a path that is not a regular USD file, which the work refuses."""
    from hairpipe.io.usd.layer_files import find_layers
    from hairpipe.io.usd.stage import SUFFIXES

    if isinstance(path, Path) and path.suffix.lower() in SUFFIXES and path.is_file():
        return find_layers(path)
    return None
