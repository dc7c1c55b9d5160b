"""Cache of results: listing, verification and removal."""

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from hairpipe.engine.file.graph import Graph
from hairpipe.engine.plan.maintenance import (
    Finding,
    Found,
    Item,
    Swept,
    clean,
    diagnose,
    items,
    live_keys,
    usage,
    verify,
)
from hairpipe.engine.plan.planner import Entry
from hairpipe.engine.plan.tasks import Task
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.ownership import check_store
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker.machine_code import kernels_parent
from hairpipe.errors import BadInput
from hairpipe.plain_file import check_plain

__all__ = ["Cache", "Found", "Item", "Swept", "open_store"]

VARIABLE, USUAL = "HAIRPIPE_CACHE", "cache"


def open_store(root: str | os.PathLike[str] | None = None, *, read_only: bool = False) -> Store:
    """Open a cache, which need not exist. BadInput for a path that is not a folder, and the cache of an untrusted user.

    root  by default the folder that HAIRPIPE_CACHE names, or `cache` in the current folder
    """
    path = Path(root if root is not None else os.environ.get(VARIABLE) or USUAL)
    check_plain(path, "a folder")
    if path.is_file():
        raise BadInput("is a file", where=path, right="a folder")
    check_store(path)
    return Store(path, read_only=read_only)


class Kept(Protocol):
    """A shot whose results are kept."""

    def graphs(self) -> list[Graph]: ...


class Cache:
    """A folder of results; `root` as for `load`."""

    def __init__(self, root: str | os.PathLike[str] | None = None) -> None:
        self._root = root
        self.root = open_store(root).root
        self._leases = Leases(self._store(read_only=True))

    def __repr__(self) -> str:
        return f"<Cache {self.root}>"

    def results(self) -> list[Item]:
        """List the results, the latest used first."""
        return sorted(items(self._store(read_only=True)), key=lambda item: -item.used)

    def usage(self) -> dict[str, tuple[int, int]]:
        """Return the number of results and their size on disk [bytes], by node type."""
        return usage(self._store(read_only=True))

    def hosts(self, plan: Iterable[Entry]) -> dict[Task, str]:
        """Find the machines on which processes compute results of a plan now; a lost one is listed for 60 s."""
        keys = {entry.task: entry.key for entry in plan if entry.status == "run" and entry.key is not None}
        leases = self._leases.holders(keys.values())
        return {task: leases[key].host or "unknown" for task, key in keys.items() if key in leases}

    def verify(self) -> Found:
        """Read every result and every compiled kernel; remove what is damaged, which the next run computes again."""
        from hairpipe.formats.hdf5 import digest_file

        kernels: Path | None = None
        with suppress(OSError):  # without a home folder there are no kernels
            kernels = kernels_parent()
        return verify(self._store(), digest_file, kernels)

    def clean(self, keep: Iterable[Kept] = (), *, older: float = 0.0, size: int = 0, dry_run: bool = False) -> Swept:
        """Remove results, least recently used first, and unreferenced objects; report their number and size.

        keep     shots whose results are kept
        older    only results that were unused for this time are removed [s]
        size     results are removed down to this size of the cache [bytes]
        dry_run  report only
        """
        kept = live_keys(self._store(), [graph for shot in keep for graph in shot.graphs()])
        return clean(self._store(read_only=dry_run), keep=kept, older=older, size=size)

    def diagnose(self) -> Iterator[Finding]:
        """Check whether the folder supports several runs, users and machines; yields findings one by one."""
        return diagnose(self._store())

    def _store(self, *, read_only: bool = False) -> Store:
        return open_store(self._root, read_only=read_only)
