"""Maintenance of a store: garbage collection, verification, and checks of its folder."""

import os
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator, Set
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple

from hairpipe.engine.file.graph import Graph
from hairpipe.engine.plan.planner import plan
from hairpipe.engine.store.atomic import discard, now_in, workspace
from hairpipe.engine.store.digest import action_key
from hairpipe.engine.store.fingerprint import digest_file, is_sealed
from hairpipe.engine.store.lease import EXPIRY, read_lease
from hairpipe.engine.store.store import Record, Store
from hairpipe.engine.store.values import parse_listing
from hairpipe.errors import BadInput

YOUNG = 3600.0
"""Minimum age of a removed unreferenced object [s]: a run may be about to reference a newer one."""
FILES, CONTENDERS = 25, 8
"""Files that are created at the same moment by as many threads."""
LITTLE = 2e9
"""Free space that a run of a few frames may fill [bytes]."""

CheckValue = Callable[[Path], str]
"""Returns the digest of the value in an object file; BadInput if there is none."""


@dataclass(frozen=True)
class Item:
    """A result in the store.

    used  time of the last use by a run, since 1970 [s]
    size  of its objects, which other results may share [bytes]
    """

    record: Record
    used: float
    size: int


@dataclass(frozen=True)
class Swept:
    """Number of removed results and objects, and their size [bytes]."""

    records: int
    objects: int
    size: int


def items(store: Store) -> Iterator[Item]:
    """Iterate over all results in a store, unordered; without damaged records."""
    for key in store.record_keys():
        path = store.action_path(key)
        record = store.record(key)
        with suppress(FileNotFoundError):  # another process may clean, too
            if record:
                yield Item(record, path.stat().st_mtime, record.size)


def objects(store: Store) -> dict[str, int]:
    """Sizes of all objects in a store by name [bytes]."""
    found = {name: store.size(name) for name in store.object_names()}
    return {name: size for name, size in found.items() if size is not None}


def usage(store: Store) -> dict[str, tuple[int, int]]:
    """Return the number of results and bytes on disk by node type; a shared object counts for the first."""
    sizes = objects(store)
    used = {}
    for item in items(store):
        count, total = used.get(item.record.parts["type"], (0, 0))
        own = sum(sizes.pop(name, 0) for name, _ in item.record.objects())
        used[item.record.parts["type"]] = (count + 1, total + own)
    if sizes:
        used["(unused)"] = (len(sizes), sum(sizes.values()))
    return used


@dataclass(frozen=True)
class Found:
    """Findings of a verification, by path in the store.

    damaged  files, which were removed
    unread   files that could not be read or removed, with reasons
    """

    damaged: list[str] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)

    def check(self, name: str, path: Path, is_whole: Callable[[], bool], remove: Callable[[Path], None]) -> None:
        """Check a file, and remove it if it is damaged."""
        try:
            if is_whole() or not os.path.lexists(path):
                return
        except (OSError, MemoryError) as error:
            self.unread.append(f"{name}: {getattr(error, 'strerror', None) or str(error) or 'not enough memory'}")
            return
        remove(path)
        if os.path.lexists(path):
            self.unread.append(f"{name}: damaged, and cannot be removed")
        else:
            self.damaged.append(name)


def verify(store: Store, check_value: CheckValue, kernels: Path | None = None) -> Found:
    """Read every record and object; remove and list those that are damaged, which runs then compute again.

    kernels  folder of compiled kernels to read too
    """
    found = Found()
    onlooker = Store(store.root, read_only=True)  # a writable store removes a damaged record when it reads it
    for key in store.record_keys():
        path = store.action_path(key)
        found.check(f"actions/{path.name}", path, lambda key=key: is_consistent(onlooker.record(key)), store.remove)
    for name in store.object_names():
        path = store.object_path(name)
        found.check(f"objects/{name}", path, lambda path=path: is_whole(path, check_value), store.remove)
    for path in kernels.glob("*/*.nbc") if kernels else ():
        found.check(f"kernels/{path.name}", path, lambda path=path: path.is_file() and is_sealed(path), discard)
    return found


def is_consistent(record: Record | None) -> bool:
    try:
        return record is not None and action_key(record.parts) == record.key
    except (TypeError, ValueError):
        return False


def is_whole(path: Path, check_value: CheckValue) -> bool:
    """Whether the content of an object matches its name; OSError or MemoryError if it cannot be read."""
    try:
        if not path.is_file():
            return False
        if path.suffix == ".h5":
            return check_value(path) == path.stem
        if path.suffix == ".set":
            listing = parse_listing(path)
            return listing is not None and listing.name == path.name
        return digest_file(path) == path.stem
    except (BadInput, FileNotFoundError, ValueError):
        return False


def live_keys(store: Store, graphs: Iterable[Graph]) -> set[str]:
    """Return the keys of the results that these graphs use, over all their frames.

    The keys of tasks that depend on a missing result are unknown: their latest ones are kept, which are valid if that
    result is unchanged.
    """
    keys: set[str] = set()
    for graph in graphs:
        latest = {name: store.latest(graph.name, name) for name in graph.nodes}
        for entry in plan(graph, store):
            node, frame = entry.task
            known = None if entry.status == "cached" else latest[node].get("" if frame is None else str(frame))
            keys.update(filter(None, (entry.key, known)))
    return keys


def clean(store: Store, *, keep: Set[str] = frozenset(), older: float = 0.0, size: int = 0) -> Swept:
    """Remove results, least recently used first, then every object that no result references.

    keep   keys of results that are never removed, see `live_keys`
    older  minimum time since the last use of a removed result [s]
    size   size of the store at which removal ends [bytes]

    A concurrent run computes missing results again.
    """
    now = store.now()
    sizes = objects(store)  # before the results: objects that a run adds meanwhile are referenced by one
    known = sorted(items(store), key=lambda item: item.used)
    held: dict[str, int] = {}
    for item in known:
        for name, _ in item.record.objects():
            held[name] = held.get(name, 0) + 1
    spare = {name for name in sizes if name not in held and is_young(store, name, now)}
    total = sum(sizes[name] for name in sizes if name in held)
    gone = 0
    for item in known:
        if total <= size or now - item.used < older:
            break
        if item.record.key in keep:
            continue
        store.remove(store.action_path(item.record.key))
        gone += 1
        for name, _ in item.record.objects():
            held[name] -= 1
            total -= 0 if held[name] else sizes.get(name, 0)
    unused = [name for name in sizes if not held.get(name) and name not in spare]
    for name in unused:
        store.remove(store.object_path(name))
    store.sweep()
    return Swept(gone, len(unused), sum(sizes[name] for name in unused))


def is_young(store: Store, name: str, now: float) -> bool:
    """Whether an object was written recently, or claimed by a run that is about to reference it."""
    with suppress(FileNotFoundError):
        return now - store.object_path(name).stat().st_mtime < YOUNG
    return False


class Finding(NamedTuple):
    """What a check of the folder of a store has found.

    verdict  ok; note: no result depends on it; fault: results may be damaged or computed twice
    meaning  consequence, and what to do
    """

    check: str
    verdict: Literal["ok", "note", "fault"]
    result: str
    meaning: str


def diagnose(store: Store) -> Iterator[Finding]:
    """Check whether the folder of a store supports several runs, users and machines; it is made where it is missing.

    Yields findings one by one; what the checks write is removed. A check that the system refuses is a fault.
    """
    with suppress(OSError):
        store.room(store.temporary / "any")
    status = store.root.stat()
    meaning = "its group writes to it" if status.st_mode & stat.S_IWGRP else "one user writes; for a group: chmod 2775"
    owner = f"user {status.st_uid}, group {status.st_gid}, {stat.filemode(status.st_mode)}"
    yield Finding("folder", "ok", owner, meaning)
    if not os.access(store.root, os.W_OK | os.X_OK):
        meaning = "results are used; a run that has to compute ends with a message: permit this user to write"
        yield Finding("writing", "note", "not permitted", meaning)
        return
    folders = [path for pattern in ("*", "*/*") for path in store.root.glob(pattern) if path.is_dir()]
    closed = sum(not os.access(path, os.W_OK | os.X_OK) for path in folders)
    meaning = "their owners: chmod -R g+rwX FOLDER, and g+s for its folders" if closed else "this user can add results"
    result = f"{closed:,} of {len(folders):,} folders not writable"
    yield Finding("permissions", "fault" if closed else "ok", result, meaning)
    free = shutil.disk_usage(store.root).free
    is_ample = free > LITTLE
    meaning = "a run stops without loss when the disk is full" if is_ample else "a run may soon stop: hairpipe cache gc"
    yield Finding("space", "ok" if is_ample else "note", f"{free / 1e9:,.1f} GB free", meaning)
    try:
        with workspace(store.temporary) as folder, ThreadPoolExecutor(CONTENDERS) as threads:
            places = [folder / f"only{number}" for number in range(FILES)]
            wins = [sum(threads.map(create, [place] * CONTENDERS)) for place in places]
        is_exclusive = set(wins) == {1}
        result = f"{wins.count(1)} of {FILES} files created once, by {CONTENDERS} threads"
    except OSError as error:
        is_exclusive = False
        result = error.strerror or str(error)
    meaning = (
        "no result is computed twice" if is_exclusive else "results are computed twice: choose another file system"
    )
    yield Finding("exclusive creation", "ok" if is_exclusive else "fault", result, meaning)
    yield age_of_leases(store)


def create(path: Path) -> bool:
    """Create a file as a lease is created; False where it exists."""
    try:
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return False
    return True


def age_of_leases(store: Store) -> Finding:
    """Compare the last renewal of each lease with the time after which it expires, by the clock of the file system."""
    found = [read_lease(path) for path in (store.root / "lease").glob("[0-9a-f]*")]
    leases = [lease for lease in found if lease is not None and lease.patience]
    hosts = sorted({lease.host or "unknown" for lease in leases})
    age = max((now_in(store.temporary) - lease.stamp / 1e9 for lease in leases), default=0.0)
    result = f"{len(leases)} held now" + (
        f", on {', '.join(hosts)}, last renewed at most {max(age, 0.0):.0f} s ago" if hosts else ""
    )
    if age > EXPIRY:
        return Finding("leases", "note", result, "of a process that ended, or is not seen: runs take it over")
    return Finding("leases", "ok", result, "a lease lasts while its holder computes")
