"""The threading layer of numba, chosen for processes that compute, before they start.

By itself numba takes TBB wherever it finds one, and versions of TBB differ: with 2021.8 each parallel call costs more
than the one before, with 2023.2 none does. OpenMP is fast in every version, so it comes first. Without it, the layer
whose calls cost least in a short measurement does. What the user's environment names is obeyed, with a warning where
its calls grow dearer.

The cost of a parallel call: a loop over few numbers, called again and again.

With some versions of TBB a call costs more than the one before, so early and late calls are measured apart.
"""

import ctypes
import json
import os
import subprocess
import sys
import time
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe import child
from hairpipe.engine.store.digest import digest
from hairpipe.engine.store.ownership import own_folder

SIZE = 2000


@njit(parallel=True)
def add_one(x: np.ndarray) -> None:
    """Add 1 to every number, (n,) float64, in place."""
    for i in prange(len(x)):
        x[i] += 1.0


def measure_calls(early: int, late: int) -> tuple[float, float]:
    """Measure the median cost of the first calls and of as many after so many others [us]."""
    x = np.zeros(SIZE)
    add_one(x)
    medians = []
    for waiting in (0, late):
        for _ in range(waiting):
            add_one(x)
        spent = []
        for _ in range(early):
            begun = time.perf_counter()
            add_one(x)
            spent.append(time.perf_counter() - begun)
        medians.append(1e6 * float(np.median(spent)))
    return medians[0], medians[1]


NAME, ORDER = "NUMBA_THREADING_LAYER", "NUMBA_THREADING_LAYER_PRIORITY"
"""Variables that name one layer, and the order in which numba tries them."""
LAYERS = ("omp", "tbb", "workqueue")
OLDEST_TBB = 12060
"""Version of TBB's interface below which numba does not use it."""
TBB = {"linux": "libtbb.so.12", "darwin": "libtbb.12.dylib"}
GROWTH = 1.5
"""Cost of late calls over that of early ones above which calls grow dearer."""


class CallCost(NamedTuple):
    """Cost of an empty parallel call [us]: of the first thousand, and after four thousand."""

    early: float
    late: float


class Layer(NamedTuple):
    """A threading layer, the environment that chooses it, and a warning for the user, empty where there is none."""

    name: str
    settings: dict[str, str]
    warning: str = ""


def choose_layer() -> Layer:
    """Choose the threading layer of processes that this one starts."""
    named = os.environ.get(NAME, "default").lower()
    order = os.environ.get(ORDER, "").split()
    if named != "default" or order:
        name = named if named != "default" else next(filter(is_loadable, order), "none")
        return Layer(name, {}, growth_warning(name))
    found = [name for name in LAYERS if is_loadable(name)]
    if found[:1] != ["omp"] and len(found) > 1:
        found.sort(key=lambda name: cost_of(name).late)
    order = [*found, *(name for name in LAYERS if name not in found)]
    return Layer(order[0], {ORDER: " ".join(order)}, growth_warning(order[0]))


def layer_in_use() -> str | None:
    """Name the layer that numba has started in this process; None before its first parallel call."""
    parallel = sys.modules.get("numba.np.ufunc.parallel")
    return None if parallel is None else vars(parallel)["_threading_layer"]


def growth_warning(name: str) -> str:
    """Warn of a layer whose calls grow dearer: versions of TBB do."""
    cost = cost_of(name) if name == "tbb" and is_loadable(name) else CallCost(0.0, 0.0)
    if cost.late <= GROWTH * cost.early:
        return ""
    return f"calls of the threading layer tbb become slower, from {cost.early:.3g} to {cost.late:.3g} us: {NAME}=omp"


@cache
def is_loadable(name: str) -> bool:
    """Whether this process could load a layer: its library and those that it is linked to."""
    numba = find_spec("numba")
    if numba is None or numba.origin is None:
        return False
    pool = {"omp": "omppool", "tbb": "tbbpool", "workqueue": "workqueue"}.get(name, name)
    path = next((Path(numba.origin).parent / "np" / "ufunc").glob(f"{pool}.*"), None)
    try:
        if path is None or (name == "tbb" and tbb_version() < OLDEST_TBB):
            return False
        ctypes.CDLL(str(path))
    except OSError:
        return False
    return True


def tbb_version() -> int:
    """Version of the interface of the TBB that the loader finds; OSError where it finds none."""
    return ctypes.CDLL(TBB.get(sys.platform, TBB["linux"])).TBB_runtime_interface_version()


@cache
def cost_of(name: str) -> CallCost:
    """Measure the cost of parallel calls with a loadable layer, in a process of its own; noted for the user."""
    note: Path | None = None
    with suppress(OSError, ValueError, TypeError):
        note = own_folder("cache") / f"threading-layer-{digest('layer', [name, version('numba'), tbb_stamp(name)])}"
        return CallCost(*map(float, json.loads(note.read_text(encoding="utf-8"))))
    environment = child.environment() | {NAME: name}
    code = "from hairpipe.engine.worker.threading_layer import report_cost; report_cost()"
    done = subprocess.run(child.command(code), env=environment, check=True, stdout=subprocess.PIPE, text=True)
    cost = CallCost(*json.loads(done.stdout))
    with suppress(OSError):
        if note is not None:
            note.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            note.write_text(json.dumps(cost), encoding="utf-8")
    return cost


def tbb_stamp(name: str) -> list[str]:
    """List path, size and time of the loaded libraries of TBB, where a layer uses it."""
    lines = Path("/proc/self/maps").read_text(encoding="utf-8").splitlines() if name == "tbb" else []
    paths = {line.partition("/")[2] for line in lines if "/libtbb" in line}
    stamps = [(path, Path(f"/{path}").stat()) for path in sorted(paths)]
    return [f"{path} {status.st_size} {status.st_mtime_ns}" for path, status in stamps]


def report_cost() -> None:
    """Print the cost of parallel calls in this process, which does nothing else, as JSON."""
    pass

    print(json.dumps(measure_calls(1000, 4000)))
