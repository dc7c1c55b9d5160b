"""Works for a child process, in a module that imports little."""

import os
import signal
import time
import warnings
from pathlib import Path
from typing import NamedTuple

from hairpipe.apart import recall


class Text(NamedTuple):
    """Content of a file, and the number of times that this process has read it."""

    words: str
    reads: int
    files: tuple[Path, ...]


reads: list[Path] = []


def build_text(path: Path) -> Text:
    reads.append(path)
    warnings.warn(f"careful with {path.name}", stacklevel=2)
    return Text(path.read_text(), len(reads), (path,))


def recall_text(path: Path) -> tuple[str, int]:
    found = recall(build_text, path)
    return found.words, found.reads


def end_by_signal(path: Path, number: int) -> None:
    os.kill(os.getpid(), number)


def crash_the_second_time(path: Path) -> int:
    """A work that fails because of what was read before."""
    reads.append(path)
    if len(reads) > 1:
        os.kill(os.getpid(), signal.SIGSEGV)
    return len(reads)


def pid_of(path: Path) -> int:
    return os.getpid()


def sleep_apart(path: Path, seconds: float) -> None:
    time.sleep(seconds)


def spend_time(path: Path, seconds: float) -> None:
    while time.process_time() < seconds:
        pass
