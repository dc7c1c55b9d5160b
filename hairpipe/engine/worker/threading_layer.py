"""The threading layer of numba, chosen for processes that compute, before they start.

By itself numba takes TBB wherever it finds one, and each parallel call of older ones costs more than the one before:
with 2021.8 the cost grows, with 2021.12 and later it does not. OpenMP is fast in every version, so it comes first.
"""

import ctypes
import os
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

NAME, ORDER = "NUMBA_THREADING_LAYER", "NUMBA_THREADING_LAYER_PRIORITY"
"""Variables that name one layer, and the order in which numba tries them."""
POOLS = {"omp": "omppool", "tbb": "tbbpool", "workqueue": "workqueue"}
"""Numba's libraries of the layers, best first."""
OLDEST_TBB, STEADY_TBB = 12060, 12120
"""Versions of TBB's interface below which numba does not use it, and below which its calls become slower."""
TBB = {"linux": "libtbb.so.12", "darwin": "libtbb.12.dylib"}


class Layer(NamedTuple):
    """A threading layer, the environment that chooses it, and a warning for the user, empty where there is none."""

    name: str
    settings: dict[str, str]
    warning: str = ""


def choose_layer() -> Layer:
    """Choose the threading layer of processes that this one starts: OpenMP, a recent TBB, else numba's own.

    What the environment of the user names is obeyed, with a warning of an older TBB.
    """
    named = os.environ.get(NAME, "default").lower()
    order = os.environ.get(ORDER, "").split()
    if named == "default" and not order:
        usable = [name for name in POOLS if is_loadable(name) and (name != "tbb" or tbb_version() >= STEADY_TBB)]
        order = [*usable, *(name for name in POOLS if name not in usable)]
        return Layer(order[0], {ORDER: " ".join(order)})
    name = named if named != "default" else next(filter(is_loadable, order), "none")
    is_slow = name == "tbb" and is_loadable(name) and tbb_version() < STEADY_TBB
    warning = f"calls of the threading layer tbb become slower: {NAME}=omp, or TBB of 2021.12 or later"
    return Layer(name, {}, warning if is_slow else "")


def layer_in_use() -> str | None:
    """Name the layer that numba has started in this process; None before its first parallel call."""
    parallel = sys.modules.get("numba.np.ufunc.parallel")
    return None if parallel is None else vars(parallel)["_threading_layer"]


@cache
def is_loadable(name: str) -> bool:
    """Whether this process could load a layer: its library and those that it is linked to."""
    numba = find_spec("numba")
    if numba is None or numba.origin is None:
        return False
    path = next((Path(numba.origin).parent / "np" / "ufunc").glob(f"{POOLS.get(name, name)}.*"), None)
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
