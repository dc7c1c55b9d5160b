"""The folder of compiled kernels, and the table of current kernels for processes.

Machine code is compiled from the module that defines a kernel and all its imports: the digest of that code is part of
the name of the folder of the module's kernels. So an edit leaves all kernels current that cannot contain it, and
checkouts with the same code share theirs. The folder lies where only this user can write, never in a store: a store may
come from anywhere, and kernels are code.
"""

import errno
import os
import shutil
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

import hairpipe
from hairpipe.engine.code import CodeReader
from hairpipe.engine.store.digest import digest
from hairpipe.engine.store.ownership import fault_of, make_own, own_folder
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker.kernel_cache import FOLDER_DIGITS, TABLE, Entry, guard_kernels, write_table
from hairpipe.engine.worker.threading_layer import choose_layer
from hairpipe.errors import BadInput

WITHOUT_KERNELS = ("api", "chart", "cli", "graph", "page", "tune", "wedge")
"""Rooms without kernels, and without types that kernels take."""
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
KEPT = 16
"""Number of states of a module whose kernels are kept: several checkouts and versions are in use in turn."""
NOTES = "notes"
"""Folder of analyses of modules, next to those of kernels: it is used by all of them, and is not removed."""
UNUSED = 30 * 24 * 3600.0
"""Age since the last use at which kernels are removed [s]."""

_digests: dict[tuple[tuple[str, str], ...], dict[str, str]] = {}
"""Digests of the code behind our modules, by the digests of these alone."""


def kernels_parent() -> Path:
    """Name the folder of all kernels: where numba was told to keep its own, else in the user's cache.

    OSError where he has no home.
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    return Path(given, "hairpipe").absolute() if given else own_folder("cache") / "kernels"


def claim_kernels(folder: Path) -> Path:
    """Make a folder for kernels that only this user can write to, or check an existing one; returns it.

    Raises BadInput if it belongs to somebody else or others may write to it, OSError if it cannot be made.
    """
    make_own(folder)
    fault = fault_of(folder)
    if fault:
        raise BadInput(f"compiled kernels are code, and the folder for them {fault}", where=folder, right=PRIVATE)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))
    return folder


def kernels_environment(folder: Path, reader: CodeReader, nodes: Iterable[str] = ()) -> dict[str, str]:
    """Environment of a process that keeps kernels in a claimed folder, for the sources as they are now.

    Writes the table of digests there, with analyses of modules, of which a new store would have none, and removes
    kernels that were not used for long.

    nodes  modules of the node types that are used: they, or what they import, may have kernels that are not ours
    """
    notes = Store(folder / NOTES)
    table = write_table(folder, kernel_digests(reader.with_notes(notes.remember), nodes))
    remove_unused(folder)
    return {TABLE: str(table)}


def share_kernels() -> None:
    """Prepare this process for computation, before it imports kernels: it shares the kernels of runs.

    The threading layer is also that of runs. Raises BadInput if others may write to the folder, or it is read-only.
    """
    try:
        folder = claim_kernels(kernels_parent())
    except OSError as error:
        raise BadInput(f"no folder for kernels: {error}", right="NUMBA_CACHE_DIR=FOLDER") from None
    reader = CodeReader(lambda name, make: make())
    os.environ |= kernels_environment(folder, reader) | choose_layer().settings
    guard_kernels()


def kernel_digests(reader: CodeReader, nodes: Iterable[str]) -> dict[str, Entry]:
    """Digest the code behind every module that may hold kernels, or types that kernels take, by its file.

    A module of ours counts with all that it imports. Those of the user count all together: what one registers with
    numba, an overload or a model of a strand, another may call without importing it. Nodes as above.
    """
    settings = {name: os.environ[name] for name in SETTINGS if name in os.environ}
    ours = our_digests(reader)
    theirs = {name: reader.code_of(name).digest for node in nodes for name in reader.modules_with_kernels(node)}
    digests = ours | dict.fromkeys(theirs, digest("kernels", theirs))
    entries = [
        Entry(name, code, digest("kernels", [digests[name], settings])) for name, code in (ours | theirs).items()
    ]
    return {reader.file_of(entry.module): entry for entry in entries}


def our_digests(reader: CodeReader) -> dict[str, str]:
    """Digest the code behind each module of this package that may hold kernels, once a process while none changes."""
    state = tuple((module, reader.own_digest(module)) for module in kernel_modules())
    if state not in _digests:
        _digests.clear()
        _digests[state] = {module: reader.code_of(module).digest for module, _ in state}
    return _digests[state]


def remove_unused(folder: Path) -> None:
    """Remove the kernels of a module whose states were used before those of `KEPT` others, or not for a month."""
    states = defaultdict[str, list[tuple[float, Path]]](list)
    with suppress(OSError):
        for entry in os.scandir(folder):
            if entry.name != NOTES:
                states[entry.name[:-FOLDER_DIGITS]].append((entry.stat().st_mtime, Path(entry.path)))
    oldest = time.time() - UNUSED
    for found in states.values():
        found.sort(reverse=True)
        for place, (used, path) in enumerate(found):
            if place >= KEPT or used < oldest:
                with suppress(OSError):
                    path.unlink() if path.is_file() else shutil.rmtree(path, ignore_errors=True)


def kernel_modules() -> Iterator[str]:
    """Name the modules of this package that hold kernels, may be called by one, or say where a name is from."""
    root = Path(hairpipe.__file__).parent
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root.parent).with_suffix("").parts
        if parts[1] not in WITHOUT_KERNELS:
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
