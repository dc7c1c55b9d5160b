"""Checks of the folder of a store on one machine: whether it does what leases and atomic files need."""

import errno
import fcntl
import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Literal, NamedTuple

from hairpipe.engine.store.atomic import flush, workspace, write_text
from hairpipe.engine.store.lease import Leases, read_lease
from hairpipe.engine.store.store import Store

FILES, CONTENDERS = 25, 8
"""Files that are created at the same moment by as many threads."""
REPLACEMENTS = 200
BLOCK = 1 << 16
"""Size of a file that is replaced while it is read [bytes]."""
LITTLE = 2e9
"""Free space that a run of a few frames may fill [bytes]."""
SLOW = 1.0
"""Delay of a listing that is worth a note [s]."""
TRIAL = "d0c7" * 10
"""Key of the leases that are tried."""

Verdict = Literal["ok", "note", "fault"]
CHOOSE = "results are computed twice, or damaged: choose another file system for the store"
MEANINGS: dict[str, tuple[str, Verdict, str]] = {
    "writing": (
        "",
        "note",
        "results are used; a run that has to compute ends with a message: permit this user to write",
    ),
    "permissions": (
        "this user can add results",
        "fault",
        "their owners: chmod -R g+rwX FOLDER, and g+s for its folders",
    ),
    "space": ("a run stops without loss when the disk is full", "note", "a run may soon stop: hairpipe cache gc"),
    "exclusive creation": ("no result is computed twice", "fault", CHOOSE),
    "replacement": ("no file is seen half written", "fault", CHOOSE),
    "links": ("files that nodes write are stored without a copy", "note", "files that nodes write are copied: slower"),
    "locks": ("not used by hairpipe", "note", "not used by hairpipe; other programs cannot rely on them"),
    "flush": ("each result waits for it at least twice", "note", ""),
    "renewal": ("a lease lasts while its holder computes", "fault", "results are computed twice: mount it with noac"),
    "listing": ("results are found by name", "note", "cache ls, gc and verify may miss the latest results"),
    "leases": ("machines share the work of a graph", "fault", CHOOSE),
    "processors": (
        "both use the same results",
        "note",
        "each class computes results of its own: combine machines of one",
    ),
    "messages": ("a result is found by the other after this time", "note", ""),
}
"""What it means that a check holds; the verdict where it does not, what that means, and what to do."""


class Finding(NamedTuple):
    """What a check has found.

    verdict  ok; note: no result depends on it; fault: results may be damaged or computed twice
    meaning  consequence, and what to do
    """

    check: str
    verdict: Verdict
    result: str
    meaning: str


def finding(check: str, holds: bool, result: str) -> Finding:
    """Judge a result by whether it is as it should be."""
    good, verdict, bad = MEANINGS[check]
    return Finding(check, "ok", result, good) if holds else Finding(check, verdict, result, bad)


def diagnose(store: Store) -> Iterator[Finding]:
    """Check the folder of a store, which is made where it is missing; what the checks write is removed.

    Yields findings one by one. A check that the system refuses is a fault.
    """
    with suppress(OSError):
        store.room(store.temporary / "any")
    yield folder(store.root)
    if not os.access(store.root, os.W_OK | os.X_OK):
        yield finding("writing", False, "not permitted")
        return
    yield permissions(store.root)
    free = shutil.disk_usage(store.root).free
    yield finding("space", free > LITTLE, f"{free / 1e9:,.1f} GB free")
    with workspace(store.temporary) as place:
        yield from (guarded(name, check, place) for name, check in CHECKS.items())
    yield guarded("leases", leases, store)


def guarded(name: str, check: Callable[..., tuple[bool, str]], *given: object) -> Finding:
    """Make a check, which does not hold where the system refuses it."""
    try:
        return finding(name, *check(*given))
    except OSError as error:
        return finding(name, False, error.strerror or str(error))


def folder(root: Path) -> Finding:
    """Name owner, permissions and file system of a folder."""
    status = root.stat()
    meaning = "its group writes to it" if status.st_mode & stat.S_IWGRP else "one user writes; for a group: chmod 2775"
    owner = f"user {status.st_uid}, group {status.st_gid}, {stat.filemode(status.st_mode)}"
    return Finding("folder", "ok", f"{file_system(root)}, {owner}", meaning)


def file_system(root: Path) -> str:
    """Name the type of file system of a folder, as Linux lists it."""
    kinds: dict[Path, str] = {}
    with suppress(OSError):
        for line in Path("/proc/mounts").read_text(encoding="utf-8", errors="replace").splitlines():
            _, place, kind, *_ = line.split()
            kinds[Path(place)] = kind
    return next((kinds[place] for place in (root, *root.parents) if place in kinds), "unknown file system")


def permissions(root: Path) -> Finding:
    """Count the folders of a store to which this user may not write."""
    folders = [path for pattern in ("*", "*/*") for path in root.glob(pattern) if path.is_dir()]
    closed = sum(not os.access(path, os.W_OK | os.X_OK) for path in folders)
    return finding("permissions", not closed, f"{closed:,} of {len(folders):,} folders not writable")


def exclusive_creation(place: Path) -> tuple[bool, str]:
    """Create files from several threads at once: of each, one creation succeeds."""
    with ThreadPoolExecutor(CONTENDERS) as threads:
        wins = [sum(threads.map(create, [place / f"only{number}"] * CONTENDERS)) for number in range(FILES)]
    return set(wins) == {1}, f"{wins.count(1)} of {FILES} files created once, by {CONTENDERS} threads"


def create(path: Path) -> bool:
    """Create a file; False where it exists."""
    try:
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return False
    return True


def replacement(place: Path) -> tuple[bool, str]:
    """Read a file while it is replaced: every reading gives one content, whole."""
    path = place / "replaced"
    replace(path, 0)
    with ThreadPoolExecutor(1) as thread:
        writing = thread.submit(lambda: [replace(path, number) for number in range(REPLACEMENTS)])
        readings = []
        while not writing.done():
            readings.append(is_one(path))
    return all(readings), f"{sum(readings):,} of {len(readings):,} readings whole"


def replace(path: Path, number: int) -> None:
    """Write a file of equal bytes in place of another."""
    write_text(path, chr(ord("a") + number % 26) * BLOCK, lasting=False)


def is_one(path: Path) -> bool:
    """Whether a file has one content, whole."""
    try:
        data = path.read_bytes()
    except OSError as error:  # a network file system may say so of an open file that was replaced: it is read again
        return error.errno == errno.ESTALE
    return len(data) == BLOCK and data.count(data[:1]) == BLOCK


def link(place: Path) -> tuple[bool, str]:
    """Make a hard link."""
    create(place / "linked")
    os.link(place / "linked", place / "link")
    return True, "supported"


def lock(place: Path) -> tuple[bool, str]:
    """Lock a file twice."""
    create(place / "locked")
    with (place / "locked").open("rb") as one, (place / "locked").open("rb") as other:
        return locked(one.fileno()) and not locked(other.fileno()), "lock of one process refused to another"


def locked(handle: int) -> bool:
    """Lock a file; False where another has its lock."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def write_through(place: Path) -> tuple[bool, str]:
    """Measure the time to write a small file to the disk."""
    (place / "flushed").write_text("x")
    begun = time.perf_counter()
    flush(place / "flushed")
    return True, f"{1e3 * (time.perf_counter() - begun):.1f} ms"


def renew(place: Path) -> tuple[bool, str]:
    """Renew the stamp of a file."""
    path = place / "renewed"
    create(path)
    os.utime(path, (0, 0))
    before = path.stat().st_mtime_ns
    with path.open("rb") as file:
        os.utime(file.fileno())
    return path.stat().st_mtime_ns != before, "stamp renewed"


def list_folder(place: Path) -> tuple[bool, str]:
    """Measure the delay after which a new file is listed."""
    names_in(place)
    create(place / "listed")
    begun = time.monotonic()
    while "listed" not in names_in(place) and time.monotonic() < begun + 10 * SLOW:
        time.sleep(0.01)
    seconds = time.monotonic() - begun
    return seconds < SLOW, f"new file listed after {seconds:.2g} s"


def names_in(folder: Path) -> set[str]:
    """List a folder."""
    return {path.name for path in folder.iterdir()}


def leases(store: Store) -> tuple[bool, str]:
    """Lease a key twice, and name the machines that compute now."""
    found = [read_lease(path) for path in (store.root / "lease").glob("[0-9a-f]*")]
    hosts = sorted({one.host or "unknown" for one in found if one is not None})
    one = Leases(store)
    other = Leases(store)
    first = one.acquire(TRIAL) and not other.acquire(TRIAL)
    one.close()
    second = other.acquire(TRIAL)
    other.close()
    return first and second, f"{len(found)} held now" + (f", on {', '.join(hosts)}" if hosts else "")


CHECKS = {
    "exclusive creation": exclusive_creation,
    "replacement": replacement,
    "links": link,
    "locks": lock,
    "flush": write_through,
    "renewal": renew,
    "listing": list_folder,
}
