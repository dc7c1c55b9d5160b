"""Work on foreign files in a child process with limits of memory and time, because a damaged file can end its reader.

Of 1 000 crate files with one to four bytes changed thirteen ended OpenUSD with a segmentation fault, and so does a text
file of 200 000 nested prims; others fill all memory, as 2 kB of references that double at each level, or compute
without end. No check of a header detects these.

The child stays: to open a file again for each frame of a shot costs more than to read it. It does one work after the
other, keeps what `recall` has opened while its files are unchanged, and ends with this process, after a minute without
work, and where a work crashes it. Such a work is repeated once in a new child, unless it was the first one there: what
a work returns does not depend on those before it.

Values sent between two processes: JSON, followed by the bytes of arrays.

The sender may have read a damaged file and is not trusted: the data names no code, and only dataclasses and NamedTuples
of this package.
"""

import atexit
import dataclasses
import gc
import importlib
import json
import math
import os
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from hairpipe.child import command, count_time, die_with_parent, environment
from hairpipe.errors import BadInput
from hairpipe.plain_file import Stamp, stamp_of

NUMBERS = "biuf"
"""Kinds of arrays that are sent: bool, integers with and without sign, floats."""
OURS = "hairpipe."


def pack(value: Any) -> bytes:
    """Write a value of None, numbers, texts, paths, arrays, lists, tuples, dicts, faults, and records of these.

    TypeError for other types.
    """
    arrays: list[np.ndarray] = []
    tree = plain(value, arrays)
    head = json.dumps([tree, [[array.dtype.str, array.shape] for array in arrays]]).encode()
    return b"".join([head, b"\n", *(np.ascontiguousarray(array).data for array in arrays)])


def unpack(data: bytes | bytearray) -> Any:
    """Read a value, with writable arrays; ValueError, LookupError or TypeError for invalid data."""
    place = data.find(b"\n") + 1
    tree, layouts = json.loads(data[:place])
    arrays = []
    for dtype, shape in layouts:
        arrays.append(np.frombuffer(data, dtype, int(np.prod(shape)), place).reshape(shape).copy())
        place += arrays[-1].nbytes
    return build(tree, arrays)


def plain(value: Any, arrays: list[np.ndarray]) -> Any:
    """Convert a value to JSON, with arrays in a list; other types are pairs of kind and content."""
    value = value.item() if isinstance(value, np.generic) else value
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Path):
        return ["path", os.fspath(value)]
    if isinstance(value, BadInput):
        return ["fault", [plain(part, arrays) for part in (value.what, value.where, value.right)]]
    if isinstance(value, np.ndarray) and value.dtype.kind in NUMBERS:
        arrays.append(value)
        return ["array", len(arrays) - 1]
    if isinstance(value, dict):
        return ["dict", [[plain(key, arrays), plain(item, arrays)] for key, item in value.items()]]
    if type(value) in (list, tuple):
        return [type(value).__name__, [plain(item, arrays) for item in value]]
    fields = fields_of(type(value))
    return [f"{type(value).__module__}:{type(value).__qualname__}", [plain(getattr(value, f), arrays) for f in fields]]


def fields_of(kind: type) -> tuple[str, ...]:
    """List the fields of a dataclass or NamedTuple of ours; TypeError for any other class."""
    if kind.__module__.startswith(OURS) and dataclasses.is_dataclass(kind):
        return tuple(field.name for field in dataclasses.fields(kind))
    if kind.__module__.startswith(OURS) and issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return tuple(vars(kind)["_fields"])
    raise TypeError(f"a {kind.__qualname__} is not sent to another process")


def build(tree: Any, arrays: list[np.ndarray]) -> Any:
    """Build a value from JSON and its arrays."""
    if not isinstance(tree, list):
        return tree
    kind, content = tree
    if kind == "path":
        return Path(content)
    if kind == "array":
        return arrays[content]
    if kind == "dict":
        return {build(key, arrays): build(item, arrays) for key, item in content}
    items = [build(item, arrays) for item in content]
    if kind == "list":
        return items
    if kind == "tuple":
        return tuple(items)
    if kind == "fault":
        what, where, right = items
        return BadInput(what, where=where, right=right)
    return record_named(kind)(*items)


def record_named(name: str) -> type:
    """Find a dataclass or NamedTuple of ours by its name; TypeError for another class."""
    module, _, own = name.partition(":")
    kind = getattr(importlib.import_module(module), own, None) if module.startswith(OURS) else None
    if not isinstance(kind, type) or kind.__module__ != module:
        raise TypeError(f"{name} is not a record of hairpipe")
    fields_of(kind)
    return kind


MEMORY = 4 << 30  # bytes: far more than a frame of any shot; OpenUSD refuses a damaged count beyond it
# Of processor time for a work, and bytes of files for each second more: ten times as long as a lint takes.
SECONDS, RATE = 60, 1e6
PATIENCE = 10  # wall-clock time over processor time, for busy computers
IDLE = 60.0
"""Time without work after which a child ends [s]."""
KEPT = 4
"""Number of opened files that a child keeps."""
TICK = 20_000_000
"""Largest delay of the clock of a file system [ns]."""
LINE = 160
"""Largest length of a message of another program."""
FULL = 3
"""Exit code of a child without memory."""
ONE_THREAD = {"PXR_WORK_THREAD_LIMIT": "1"}
"""Environment of a child: a thread of OpenUSD without memory may end by a segmentation fault."""
OVERDUE = (signal.SIGXCPU, signal.SIGALRM)
Result = TypeVar("Result")


def work_apart(work: Callable[..., Result], path: Path, *arguments: Any) -> Result:
    """Return `work(path, *arguments)`, done in a child process, with its warnings and BadInput.

    work  a function of a module; its arguments and result are values that `wire` supports

    Raises BadInput where the work raises any exception but for a missing module, and where the process crashes or
    exceeds its limits of memory and time.
    """
    request = pack((work.__module__, work.__name__, _folder(), path, arguments))
    with _lock:
        result, warned = _answer(request, path)
    for warning in warned:
        warnings.warn(warning, UserWarning, stacklevel=2)
    if isinstance(result, BadInput):
        raise result
    return result


def recall(build: Callable[..., Result], *arguments: Any) -> Result:
    """Return `build(*arguments)`; in a child, what an earlier work has built, as long as its files are unchanged.

    Warnings of the first time are given each time.

    build      a function or class of a module; `files` of what it builds are all files and folders on which it depends
    arguments  values that can be compared, such as paths and texts
    """
    return build(*arguments) if _service is None else _service.recall(build, arguments)


def extend_time(size: int) -> None:
    """Give the present work of a child the processor time for further files of a size [bytes]."""
    if _service is not None:
        _service.limit_time(size)


class Child:
    """A child process that does works; `is_fresh` until it has done one."""

    def __init__(self) -> None:
        self.is_fresh = True
        self.counted = 0.0
        self.log = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
        ours, theirs = socket.socketpair()
        with theirs:
            self.process = subprocess.Popen(
                command(f"from {__name__} import serve; serve()"),
                stdin=theirs.fileno(),
                stdout=self.log,
                stderr=self.log,
                env=environment() | ONE_THREAD,
            )
        self.connection = Connection(ours.detach())

    def ask(self, request: bytes) -> tuple[Any, list[str]] | None:
        """Return result and warnings of a work; None where the process has ended."""
        self.log.seek(0)
        self.log.truncate()
        try:
            self.connection.send_bytes(request)
            answer = self.connection.recv_bytes()
        except (OSError, EOFError):
            return None
        result, warned, spent = unpack(answer)
        self.count(spent)
        self.is_fresh = False
        return result, warned

    def count(self, spent: float) -> None:
        count_time(spent - self.counted)
        self.counted = spent

    def end(self, kill: bool = False) -> tuple[int, str]:
        """End the process, unless it has ended; return its exit code and what it printed."""
        if kill:
            self.process.kill()
        self.process.wait()
        self.count(0.0)  # the system counts children that have ended
        self.log.seek(0)
        printed = self.log.read().decode(errors="replace")
        self.leave()
        return self.process.returncode, printed

    def leave(self) -> None:
        self.connection.close()
        self.log.close()


_lock = threading.Lock()
_kept: list[Child] = []
"""The child of this process, if it has one."""


def _answer(request: bytes, path: Path) -> tuple[Any, list[str]]:
    """Return result and warnings of a work; repeat it where a child that did others before has ended."""
    while True:
        child = _kept.pop() if _kept else Child()
        try:
            answer = child.ask(request)
        except BaseException:
            child.end(kill=True)
            raise
        is_unlimited = resource.getrlimit(resource.RLIMIT_CPU)[1] == resource.RLIM_INFINITY
        if answer is not None and is_unlimited:  # else the system kills the child at the limit, without a message
            _kept.append(child)
        code, printed = (0, "") if _kept else child.end(kill=answer is not None)
        if answer is not None:
            return answer
        if child.is_fresh or -code in OVERDUE:
            raise _death(code, printed, path)


@atexit.register
def _end_child() -> None:
    while _kept:
        _kept.pop().end(kill=True)


def _leave_child() -> None:
    """Leave the child to the process from which this one was forked."""
    global _lock
    _lock = threading.Lock()
    while _kept:
        child = _kept.pop()
        child.leave()
        child.process.returncode = 0


os.register_at_fork(after_in_child=_leave_child)


def _folder() -> str | None:
    """Return the current folder; None where it is gone."""
    try:
        return os.getcwd()  # noqa: PTH109 - a text
    except FileNotFoundError:
        return None


def _death(code: int, printed: str, path: Path) -> Exception:
    if -code in OVERDUE:
        what = f"takes more than {SECONDS} s of processor time, and {1e6 / RATE:g} s per MB of its files"
        return BadInput(what, where=path, right="fewer nested references or instances")
    if code == FULL or "bad_alloc" in printed:
        what = f"takes more than {most_memory() / 2**30:.2g} GiB of memory"
        return BadInput(what, where=path, right="a smaller file")
    if code >= 0:
        return RuntimeError(f"{path} was not read:\n{printed}")
    cause = signal.Signals(-code).name
    return BadInput(f"the reader crashes on the file ({cause})", where=path, right="a file that is not damaged")


def most_memory() -> int:
    """Return the memory limit of a child [bytes]: MEMORY, or the lower limit of this process."""
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    return MEMORY if hard == resource.RLIM_INFINITY else min(MEMORY, hard)


def limit_memory() -> None:
    most = most_memory()
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))


class Kept(NamedTuple):
    """What was built, its warnings, and the stamps of its files; none where it is not kept."""

    value: Any
    warned: list[str]
    stamps: dict[str, Stamp]


class Service:
    """State of a child: what it keeps, and the limits of its present work."""

    def __init__(self) -> None:
        self.kept: dict[Any, Kept] = {}
        self.own, self.hard = resource.getrlimit(resource.RLIMIT_CPU)
        self.begun = 0.0
        self.is_recalled = False

    def limit_time(self, size: int) -> None:
        """Limit the processor time of the present work, on files of a size [bytes], and its duration."""
        seconds = SECONDS + int(size / RATE)
        # The system sends SIGKILL at the hard limit, without a message.
        limits = [seconds, *(limit for limit in (self.own, self.hard - 1) if limit >= 0)]
        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(self.begun) + min(limits), self.hard))
        signal.alarm(PATIENCE * seconds)

    def carry_out(
        self, module: str, name: str, folder: str | None, path: Any, arguments: tuple[Any, ...]
    ) -> tuple[Any, list[str]]:
        """Do a work; return its result, or why there is none, and its warnings."""
        self.begun = time.process_time()
        self.limit_time(path.stat().st_size if isinstance(path, Path) and path.is_file() else 0)
        if folder is not None and folder != _folder():
            self.kept.clear()
            os.chdir(folder)
        self.is_recalled = False
        self.forget_changed()
        work = getattr(importlib.import_module(module), name)
        with recorded() as warned:
            try:
                result = work(path, *arguments)
            except BadInput as fault:
                result = fault
            except (MemoryError, ImportError):
                raise
            except Exception as error:
                cause = f"{type(error).__name__}: {' '.join(str(error).split())[:LINE]}"
                named = f"{path.suffix.lower()} file" if isinstance(path, Path) and path.suffix else "file"
                result = BadInput(f"not a readable {named} ({cause})", where=path, right="a file that is not damaged")
        return result, warned

    def recall(self, build: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """Return what was built before; otherwise build it, and keep it if its files have not changed meanwhile."""
        key = build, arguments
        found = self.kept.pop(key, None)
        self.is_recalled = found is not None
        found = found or self.build(build, arguments)
        if found.stamps:
            self.kept[key] = found
        while len(self.kept) > KEPT:
            del self.kept[next(iter(self.kept))]
        for warning in found.warned:
            warnings.warn(warning, UserWarning, stacklevel=4)
        return found.value

    def build(self, build: Callable[..., Any], arguments: tuple[Any, ...]) -> Kept:
        """Build something; without stamps where one of its files has changed since the begin, or is missing."""
        begun = time.time_ns() - TICK
        with recorded() as warned:
            value = build(*arguments)
        stamps = {str(file): stamp_of(str(file)) for file in value.files}
        is_settled = all(stamp and stamp[-1] < begun for stamp in stamps.values())
        return Kept(value, warned, stamps if is_settled else {})

    def forget_changed(self) -> None:
        for key, found in list(self.kept.items()):
            if any(stamp_of(file) != stamp for file, stamp in found.stamps.items()):
                del self.kept[key]


@contextmanager
def recorded() -> Iterator[list[str]]:
    """Collect the warnings for users in this block."""
    found = list[str]()
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always", UserWarning)
        yield found
    found += [str(w.message) for w in warned if w.category is UserWarning]


_service: Service | None = None
"""That of this process, if it is such a child."""


def serve() -> None:
    """Do the works that are asked for on standard input, a socket, until it is closed or nothing is asked for."""
    global _service
    die_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends what it has asked for
    connection = Connection(os.dup(sys.stdin.fileno()))
    limit_memory()
    service = _service = Service()
    while connection.poll(IDLE):
        try:
            request = connection.recv_bytes()
        except (OSError, EOFError):
            return
        try:
            result, warned = service.carry_out(*unpack(request))
            answer = pack((result, warned, time.process_time()))
        except MemoryError:
            os._exit(FULL)
        signal.alarm(0)
        connection.send_bytes(answer)
        del result, request, answer
        if not service.is_recalled:
            gc.collect()  # a layer of OpenUSD that something refers to is not read again
