"""Checks of a store between two machines, which run them at the same time and talk by files of the store alone.

Each writes what it has to say into a file of its own, and reads that of the other. Delays are measured by the clock of
one machine, from an act to the answer of the other.
"""

import json
import os
import shutil
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from hairpipe.engine.store.atomic import making, share, sweep
from hairpipe.engine.store.digest import parsed
from hairpipe.engine.store.doctor import (
    FILES,
    REPLACEMENTS,
    SLOW,
    TRIAL,
    Finding,
    create,
    finding,
    is_one,
    locked,
    names_in,
    replace,
)
from hairpipe.engine.store.holder import renewal
from hairpipe.engine.store.lease import EXPIRY, Leases, read_lease
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.processor import processor_class

PATIENCE = 120.0
"""Time that the other machine has to begin, and to answer [s]."""
DELAY = 60.0
"""Time that a change on one machine has to be seen on the other [s]."""
PAUSE = 0.02
"""Time between two readings of what the other writes [s]."""
ROUNDS = 10
"""Messages whose delay is measured."""
PACE = 0.002
"""Time between two files that are created [s]."""


def diagnose_pair(store: Store) -> Iterator[Finding]:
    """Check a store between this machine and another one, which has to begin within two minutes.

    Yields findings one by one, the same on both. BadInput where the other does not answer.
    """
    try:
        with meeting(store) as partner:
            for name, check in CHECKS.items():
                yield finding(name, *check(partner))
    except OSError as error:
        yield finding("writing", False, error.strerror or str(error))


class Partner:
    """The other machine, and what each of the two has written.

    is_first  whether this machine acts first
    place     folder of both
    leases    of this machine
    """

    def __init__(self, store: Store, own: Path, handle: int) -> None:
        self.store = store
        self.leases = Leases(store)
        self.host = ""
        self.place = own.parent
        self.is_first = False
        self._own = own
        self._handle = handle
        self._other: Path | None = None
        self._said: list[dict[str, Any]] = []
        self._beat = 0

    def meet(self) -> None:
        """Find a machine that writes, and wants this one."""
        first: dict[Path, int] = {}
        end = time.monotonic() + PATIENCE
        while True:
            self._write()
            if self._other is not None and not self._other.exists():
                self._other = None
            for path in self._own.parent.glob(".hairpipe-*.tmp"):
                found = self._read(path) if path != self._own else None
                if found is None:  # this machine's, gone, or being written: that one may be waiting for this machine
                    continue
                if found["with"] not in ("", self._own.name):
                    first.pop(path, None)
                    self._other = None if path == self._other else self._other
                elif first.setdefault(path, found["beat"]) != found["beat"]:  # it is alive
                    self._other = self._other or path
                    if path == self._other and found["with"] == self._own.name:
                        self._write()
                        self.host = found["host"]
                        self.is_first = self._own.name < path.name
                        self.place = self._own.parent / min(self._own.stem, path.stem)
                        return
            self._check(end)

    def exchange(self, **facts: Any) -> dict[str, Any]:
        """Write facts, and return those of the other once they are there: both go on from here together."""
        self._said.append(facts)
        self._write()
        end = time.monotonic() + PATIENCE
        while (answer := self.answer(len(self._said) - 1)) is None:
            self._check(end)
        return answer

    def answer(self, number: int | None = None) -> dict[str, Any] | None:
        """Return the facts of the other of this number, by default the next ones; None where they are not there yet."""
        number = len(self._said) if number is None else number
        found = None if self._other is None else self._read(self._other)
        return found["said"][number] if found and len(found["said"]) > number else None

    def leave(self) -> None:
        """End the conversation; the first machine removes its file first, since it waits for the last facts."""
        if self.is_first:
            self.exchange()
            shutil.rmtree(self.place, ignore_errors=True)
        else:
            self._said.append({})
            self._write()
            wait_until(lambda: self._other is None or not self._other.exists())

    def share(self, *values: Any) -> list[Any]:
        """Return the values of the second machine, on both."""
        other = self.exchange(values=values)["values"]
        return list(other if self.is_first else values)

    def answered_after(self, begun: float) -> float:
        """Wait for the second machine; returns the time since the start of the first, by its clock [s]."""
        self.exchange()
        own = time.monotonic() - begun
        other = self.exchange(seconds=own)["seconds"]
        return float(own if self.is_first else other)

    def _check(self, end: float) -> None:
        """Wait for a moment; BadInput after the end."""
        if time.monotonic() > end:
            who = self.host or "a second machine"
            raise BadInput(f"{who} does not answer", where=self._own.parent, right="--pair on two machines at one time")
        time.sleep(PAUSE)

    def _write(self) -> None:
        """Write everything so far into the file of this machine, in place and through to the server."""
        self._beat += 1
        document = {"host": socket.gethostname(), "beat": self._beat, "said": self._said}
        document["with"] = "" if self._other is None else self._other.name
        text = json.dumps(document).encode()
        os.ftruncate(self._handle, len(text))
        os.pwrite(self._handle, text, 0)
        os.fsync(self._handle)

    def _read(self, path: Path) -> dict[str, Any] | None:
        """Read what another machine has written; None where it is being written, or gone."""
        try:
            found = parsed(path.read_bytes())
            whole_document = found.keys() == {"host", "beat", "said", "with"}
        except (OSError, ValueError, AttributeError):
            return None
        return found if whole_document else None


@contextmanager
def meeting(store: Store) -> Iterator[Partner]:
    """Meet another machine in a folder of the store, which is removed at the end."""
    folder = store.room(store.root / "doctor" / "any").parent
    sweep(folder)
    try:
        with making(folder) as (own, handle):
            partner = Partner(store, own, handle)
            partner.meet()
            if partner.is_first:
                partner.place.mkdir()
                share(partner.place, folder)
            partner.exchange()
            yield partner
            partner.leave()
    finally:
        with suppress(OSError):
            folder.rmdir()


def wait_until(condition: Callable[[], bool]) -> bool:
    """Wait until a condition holds, but not for ever; whether it holds."""
    end = time.monotonic() + DELAY
    while not (holds := condition()) and time.monotonic() < end:
        time.sleep(PAUSE)
    return holds


def compare_processors(partner: Partner) -> tuple[bool, str]:
    """Compare the classes of the processors."""
    own = processor_class()
    other = partner.exchange(processor=own)["processor"]
    return own == other, " and ".join(sorted({own, other}))


def send_messages(partner: Partner) -> tuple[bool, str]:
    """Measure the delay of a message through a file."""
    begun = time.monotonic()
    for _ in range(ROUNDS):
        partner.exchange()
    own = (time.monotonic() - begun) / ROUNDS
    seconds = max(own, partner.exchange(seconds=own)["seconds"])
    return True, f"{seconds:.2g} s between {' and '.join(sorted([socket.gethostname(), partner.host]))}"


def create_files(partner: Partner) -> tuple[bool, str]:
    """Create the same files on both machines, in opposite orders: of each, one creation succeeds."""
    own = []
    for number in range(FILES) if partner.is_first else reversed(range(FILES)):
        own += [number] if create(partner.place / f"only{number}") else []
        time.sleep(PACE)
    wins = [*own, *partner.exchange(wins=own)["wins"]]
    once = sum(wins.count(number) == 1 for number in range(FILES))
    return once == FILES, f"{once} of {FILES} files created once, by 2 machines"


def replace_file(partner: Partner) -> tuple[bool, str]:
    """Read a file on one machine while the other replaces it."""
    path = partner.place / "replaced"
    readings = []
    if partner.is_first:
        replace(path, 0)
    partner.exchange()
    if partner.is_first:
        for number in range(REPLACEMENTS):
            replace(path, number)
    else:
        while partner.answer() is None:
            readings.append(is_one(path))
    partner.exchange()
    whole = partner.share(sum(readings), len(readings))
    return whole[0] == whole[1], f"{whole[0]:,} of {whole[1]:,} readings whole"


def link_file(partner: Partner) -> tuple[bool, str]:
    """Make a hard link on one machine, and count the links on the other."""
    path = partner.place / "linked"
    if partner.is_first:
        create(path)
        with suppress(OSError):
            os.link(path, partner.place / "link")
    partner.exchange()
    (links,) = partner.share(path.stat().st_nlink)
    return links == 2, "seen by both" if links == 2 else "not seen by both"


def lock_file(partner: Partner) -> tuple[bool, str]:
    """Lock a file on one machine, and try to on the other."""
    path = partner.place / "locked"
    if partner.is_first:
        create(path)
    partner.exchange()
    refused = False
    with path.open("rb") as file:
        for turn in (partner.is_first, not partner.is_first):
            with suppress(OSError):  # of a file system without locks
                refused = turn and not locked(file.fileno())
            partner.exchange()
        (refused,) = partner.share(refused)
        return refused, f"lock of one machine {'refused' if refused else 'granted'} to the other"


def list_folder(partner: Partner) -> tuple[bool, str]:
    """Measure the delay after which a file of one machine is listed on the other, which has just listed the folder."""
    names_in(partner.place)
    partner.exchange()
    begun = time.monotonic()
    if partner.is_first:
        create(partner.place / "listed")
    else:
        wait_until(lambda: "listed" in names_in(partner.place))
    seconds = partner.answered_after(begun)
    return seconds < SLOW, f"new file listed after {seconds:.2g} s at most"


def renew_lease(partner: Partner) -> tuple[bool, str]:
    """Renew a lease on one machine, and read it on the other, which has just read it before."""
    path = partner.store.root / "lease" / TRIAL
    if partner.is_first:
        partner.leases.acquire(TRIAL)
    partner.exchange()
    before = read_lease(path)
    partner.exchange()
    begun = time.monotonic()
    if partner.is_first:
        renewal.renew()
    else:
        wait_until(lambda: read_lease(path) != before)
    seconds = partner.answered_after(begun)
    return seconds < EXPIRY / 2, f"seen after {seconds:.2g} s at most"


def give_lease(partner: Partner) -> tuple[bool, str]:
    """Refuse a lease of one machine to the other until it is given back."""
    (refused,) = partner.share(not partner.is_first and not partner.leases.acquire(TRIAL))
    if partner.is_first:
        partner.leases.release(TRIAL)
    partner.exchange()
    (granted,) = partner.share(not partner.is_first and wait_until(lambda: partner.leases.acquire(TRIAL)))
    partner.leases.close()
    return refused and granted, f"{'refused' if refused else 'granted twice'}, {'given' if granted else 'lost'}"


CHECKS = {
    "processors": compare_processors,
    "messages": send_messages,
    "exclusive creation": create_files,
    "replacement": replace_file,
    "links": link_file,
    "locks": lock_file,
    "listing": list_folder,
    "renewal": renew_lease,
    "leases": give_lease,
}
