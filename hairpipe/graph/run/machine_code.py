"""The cache of compiled kernels: numba detects edits of the file that defines a kernel, not of those that it calls.

So each state of the sources has a folder of its own, and old machine code of an edited callee is never loaded; so has
each way to compile that the environment asks for. The folders lie where only this user can write, never in a store: a
store may come from anywhere, and kernels are code.
"""

import errno
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

import hairpipe
from hairpipe.errors import BadInput
from hairpipe.graph.key.code import ALWAYS, CodeReader, version
from hairpipe.graph.store.digest import digest
from hairpipe.graph.store.ownership import fault_of, make_own, own_folder

WITHOUT_KERNELS = ("api", "chart", "cli", "graph", "page", "tune")
"""Rooms without kernels: editing them invalidates no compiled kernel."""
PRIVATE = "a folder of your own that you alone can write to (chmod go-w)"
SETTINGS = (
    "NUMBA_BOUNDSCHECK",
    "NUMBA_DEBUGINFO",
    "NUMBA_DISABLE_INTEL_SVML",
    "NUMBA_LOOP_VECTORIZE",
    "NUMBA_OPT",
    "NUMBA_SLP_VECTORIZE",
)
"""Of the environment, by which numba compiles otherwise, though it looks a kernel up by none of them."""
KEPT = 8
"""Number of states of the sources whose kernels are kept, for switching between versions and users' nodes."""


def kernels_parent() -> Path:
    """Name the folder for kernels of all states: where numba was told to keep its own, else in the user's cache.

    OSError where he has no home.
    """
    told = os.environ.get("NUMBA_CACHE_DIR")
    return Path(told, "hairpipe").absolute() if told else own_folder("cache") / "kernels"


def claim_kernels(folder: Path) -> Path:
    """Make a folder for kernels that this user alone can write to, or check that one is; returns it.

    Raises BadInput where it is somebody else's or others may write to it, OSError where there can be none.
    """
    make_own(folder)
    fault = fault_of(folder)
    if fault:
        raise BadInput(f"compiled kernels are code, and the folder for them {fault}", where=folder, right=PRIVATE)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))
    return folder


def kernel_folder(parent: Path, reader: CodeReader, nodes: Iterable[str] = ()) -> Path:
    """Give the folder, below a parent, for kernels of the sources as they are now, and remove those unused for longest.

    nodes  modules of the node types that are used: they, or what they import, may have kernels that are not ours
    """
    versions = {name: version(name) for name in ALWAYS}
    settings = {name: os.environ[name] for name in SETTINGS if name in os.environ}
    folder = parent / digest("kernels", [kernel_sources(reader, nodes), versions, settings, "sealed"])[:24]
    with suppress(OSError):
        others = sorted(parent.iterdir(), key=lambda other: other.stat().st_mtime, reverse=True)
        for other in [other for other in others if other != folder][KEPT - 1 :]:
            shutil.rmtree(other, ignore_errors=True)
        os.utime(folder)
    return folder


def kernel_sources(reader: CodeReader, nodes: Iterable[str]) -> dict[str, str]:
    """Digests of all modules that kernels may be compiled of, by name; nodes as for `kernel_folder`."""
    found = {module: reader.own_digest(module) for module in kernel_modules()}
    for module in nodes:
        found |= reader.kernel_sources(module)
    return found


def clear_kernels(folder: Path) -> None:
    """Remove the kernels in a folder; the folders in it stay, since another run may be about to write there."""
    for path in folder.rglob("*.nb[ci]"):
        path.unlink(missing_ok=True)


def kernel_modules() -> Iterator[str]:
    """Name the modules of this package that hold kernels, may be called by one, or say where a name is from."""
    root = Path(hairpipe.__file__).parent
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root.parent).with_suffix("").parts
        if parts[1] not in WITHOUT_KERNELS:
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
