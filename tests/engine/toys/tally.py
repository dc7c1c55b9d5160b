"""Counts evaluations in a file, and kills a run at the n-th file that a worker is about to put in its place."""

import os
import signal
import sys
from pathlib import Path

import numpy as np
from numeral import Numeral

FACTOR = 1.0


def tally(name, frame=None):
    with Path(os.environ["TOY_TALLY"]).open("a") as file:
        file.write(f"{name} {'' if frame is None else frame}".strip() + "\n")


def numeral(value):
    return Numeral(value * FACTOR, np.full(int(os.environ.get("TOY_SIZE", 4)), value))


def kill_at_rename(number):
    renames, replace = 0, Path.replace

    def killing(self, target):
        nonlocal renames
        renames += 1
        if renames == number:
            os.kill(os.getppid(), signal.SIGKILL)
            os.kill(os.getpid(), signal.SIGKILL)
        return replace(self, target)

    Path.replace = killing


# The process of the tests may have imported the module of workers, too.
IN_WORKER = "hairpipe.engine.worker.worker" in sys.modules and "pytest" not in sys.modules

if IN_WORKER and "TOY_KILL_AT_RENAME" in os.environ:
    kill_at_rename(int(os.environ["TOY_KILL_AT_RENAME"]))
