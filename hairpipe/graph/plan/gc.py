"""Housekeeping of a store: what is in it, whether it is whole, and what may go."""

import os
import time
from collections.abc import Callable, Iterable, Iterator, Set
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.plan.planner import plan
from hairpipe.graph.store.atomic import discard
from hairpipe.graph.store.digest import action_key
from hairpipe.graph.store.fingerprint import digest_file
from hairpipe.graph.store.listing import parse_listing
from hairpipe.graph.store.record import Record
from hairpipe.graph.store.seal import is_sealed
from hairpipe.graph.store.store import Store

YOUNG = 3600.0
"""Age below which an object that no result holds is spared: a run may be about to hold it [s]."""

CheckValue = Callable[[Path], str]
"""Gives the digest of the value in an object file; BadInput where there is none."""


@dataclass(frozen=True)
class Item:
    """A result in the store.

    used  when it was last established by a run, in seconds since 1970 [s]
    size  of its objects, some of which other results may share [bytes]
    """

    record: Record
    used: float
    size: int


@dataclass(frozen=True)
class Swept:
    """What a cleaning removed: results, objects, and bytes."""

    records: int
    objects: int
    size: int


def items(store: Store) -> Iterator[Item]:
    """Iterate over all results in a store, unordered; damaged records are left out."""
    for key in store.record_keys():
        path, record = store.action_path(key), store.record(key)
        with suppress(FileNotFoundError):  # another process may clean, too
            if record:
                yield Item(record, path.stat().st_mtime, record.size)


def objects(store: Store) -> dict[str, int]:
    """Sizes of all objects in a store by name [bytes]."""
    found = {name: store.size(name) for name in store.object_names()}
    return {name: size for name, size in found.items() if size is not None}


def usage(store: Store) -> dict[str, tuple[int, int]]:
    """Number of results and bytes on disk by node type; an object that is shared counts for the first that has it."""
    sizes, used = objects(store), {}
    for item in items(store):
        count, total = used.get(item.record.parts["type"], (0, 0))
        own = sum(sizes.pop(name, 0) for name, _ in item.record.objects())
        used[item.record.parts["type"]] = (count + 1, total + own)
    if sizes:
        used["(unused)"] = (len(sizes), sum(sizes.values()))
    return used


@dataclass(frozen=True)
class Found:
    """What a reading of everything has found, by path in the store.

    damaged  and removed
    unread   what cannot be told of, or not be removed, and why
    """

    damaged: list[str] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)

    def take(self, name: str, path: Path, is_whole: Callable[[], bool], remove: Callable[[Path], None]) -> None:
        """Look at a file, and remove it where it is damaged."""
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
    """Read every record and object; remove and name those that are damaged, so that they are computed again.

    kernels  folder of compiled kernels to read too
    """
    found = Found()
    onlooker = Store(store.root, read_only=True)  # a store that may write removes a damaged record as it reads it
    for key in store.record_keys():
        path = store.action_path(key)
        found.take(f"actions/{path.name}", path, lambda key=key: is_true(onlooker.record(key)), store.remove)
    for name in store.object_names():
        path = store.object_path(name)
        found.take(f"objects/{name}", path, lambda path=path: is_whole(path, check_value), store.remove)
    for path in kernels.glob("*/*/*.nb[ci]") if kernels else ():
        found.take(f"kernels/{path.name}", path, lambda path=path: path.is_file() and is_sealed(path), discard)
    return found


def is_true(record: Record | None) -> bool:
    """Whether a record is there, and its key made of what it says."""
    try:
        return record is not None and action_key(record.parts) == record.key
    except (TypeError, ValueError):
        return False


def is_whole(path: Path, check_value: CheckValue) -> bool:
    """Whether an object is what its name says; OSError or MemoryError where that cannot be found out."""
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


def reached(store: Store, graphs: Iterable[Graph]) -> set[str]:
    """Keys of the results that these graphs would find, over all their frames.

    The keys of those behind one that is missing are not known yet: their latest ones count, which will be found again
    if it comes out as before.
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
    """Remove results, least recently used first, then every object that no result holds.

    keep   keys of results that stay in any case, as `reached` gives them
    older  only results unused for this long go [s]
    size   they go until the store takes no more than this [bytes]

    A run that is under way loses nothing but time: what it misses it computes again.
    """
    sizes = objects(store)  # before the results: what a run adds meanwhile is held by one
    known = sorted(items(store), key=lambda item: item.used)
    held: dict[str, int] = {}
    for item in known:
        for name, _ in item.record.objects():
            held[name] = held.get(name, 0) + 1
    spare = {name for name in sizes if name not in held and is_young(store, name)}
    total, gone, now = sum(sizes[name] for name in sizes if name in held), 0, time.time()
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


def is_young(store: Store, name: str) -> bool:
    """Whether an object was written, or asked for by a run that is about to hold it, a short time ago."""
    with suppress(FileNotFoundError):
        return time.time() - store.object_path(name).stat().st_mtime < YOUNG
    return False
