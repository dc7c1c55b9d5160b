"""The threading layer of numba, chosen for processes that compute, before they start, and the number of its threads.

By itself numba takes TBB wherever it finds one; each parallel call of version 2021.8 costs more than the one before.
So OpenMP comes first, then numba's own. Threads of OpenMP wait in a loop, for milliseconds: next to busy programs one
with work would wait for the core of one without. They sleep almost at once, as numba's own do: `hairpipe bench busy`.
"""

import ctypes
import os
import sys
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from hairpipe.errors import BadInput

NAME, ORDER = "NUMBA_THREADING_LAYER", "NUMBA_THREADING_LAYER_PRIORITY"
"""Variables that name one layer, and the order in which numba tries them."""
POOLS = {"omp": "omppool", "workqueue": "workqueue", "tbb": "tbbpool"}
"""Numba's libraries of the layers, best first."""
SPIN = {"GOMP_SPINCOUNT": "100", "KMP_BLOCKTIME": "0"}
"""Turns that a thread of GNU's OpenMP waits before it sleeps, and milliseconds that one of LLVM's or Intel's does."""
WAITING = {"OMP_WAIT_POLICY", *SPIN}
"""Variables that say how threads wait; where one is set, none is added."""
THREADS = "NUMBA_NUM_THREADS"
QUOTA = Path("/sys/fs/cgroup/cpu.max")
"""Processor time that a container may use, and in which time [us]."""


class Layer(NamedTuple):
    """A threading layer, and the environment that chooses it."""

    name: str
    settings: dict[str, str]


def choose_layer() -> Layer:
    """Choose the threading layer of processes that this one starts: what the environment names, else the best one."""
    named = os.environ.get(NAME, "default").lower()
    order = os.environ.get(ORDER, "").split()
    settings = {} if WAITING & os.environ.keys() else SPIN
    if named == "default" and not order:
        order = sorted(POOLS, key=lambda name: not is_loadable(name))
        settings = settings | {ORDER: " ".join(order)}
    return Layer(named if named != "default" else next(filter(is_loadable, order), "none"), settings)


def usable_cores() -> int:
    """Number of cores for threads: what THREADS says, else those that this process is given; BadInput for no number."""
    if (named := os.environ.get(THREADS)) is not None:
        if not (named.isascii() and named.isdigit() and int(named) > 0):
            raise BadInput(f"'{named}' is no number of threads", where=THREADS, right="a whole number from 1")
        return int(named)
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    try:
        allowed, period = map(int, QUOTA.read_text(encoding="ascii").split())
        return max(1, min(cores, round(allowed / period)))
    except (OSError, ValueError):  # no container, or no limit
        return cores


def layer_in_use() -> str | None:
    """Name the layer that numba has started in this process; None before its first parallel call."""
    parallel = sys.modules.get("numba.np.ufunc.parallel")
    return None if parallel is None else vars(parallel)["_threading_layer"]


def is_loadable(name: str) -> bool:
    """Whether this process could load a layer: its library and those that it is linked to."""
    numba = find_spec("numba")
    places = (numba and numba.submodule_search_locations) or []
    path = next((path for place in places for path in Path(place, "np/ufunc").glob(f"{POOLS.get(name, name)}.*")), None)
    with suppress(OSError):
        return path is not None and bool(ctypes.CDLL(str(path)))
    return False
