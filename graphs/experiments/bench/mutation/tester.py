"""Runs tests of changed code: a process that has imported what all tests import, and forks one for each request.

A request is a line of JSON: the arguments of pytest, and a limit [s]. The answer is another: the exit code of pytest,
None where the limit was reached. Nothing of hairpipe is imported before a fork: each process imports it as it is then.
"""

import importlib
import json
import os
import signal
import sys
import time
from contextlib import suppress

IMPORTED = ("numba", "numpy", "pydantic", "h5py", "pytest", "hypothesis", "tomlkit", "click", "rich")
PAUSE = 0.02
"""Between two looks at the process [s]."""


def main() -> None:
    """Answer requests until there are none."""
    for name in IMPORTED:
        importlib.import_module(name)
    for line in sys.stdin:
        words, limit = json.loads(line)
        print(json.dumps(run_tests(words, limit)), flush=True)


def run_tests(words: list[str], limit: float) -> int | None:
    """Run pytest in a forked process, at the head of a group of its own, which ends with it."""
    process = os.fork()
    if process == 0:
        os.setsid()
        nothing = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(nothing, descriptor)
        os._exit(test(words))
    end = time.monotonic() + limit
    ended = status = 0
    while not ended and time.monotonic() < end:
        ended, status = os.waitpid(process, os.WNOHANG)
        time.sleep(0 if ended else PAUSE)
    with suppress(ProcessLookupError):
        os.killpg(process, signal.SIGKILL)
    if not ended:
        os.waitpid(process, 0)
        return None
    return os.waitstatus_to_exitcode(status)


def test(words: list[str]) -> int:
    """Run pytest in this process; 1 where changed code ends it."""
    try:
        return int(importlib.import_module("pytest").main(words))
    except BaseException:
        return 1


if __name__ == "__main__":
    main()
