"""The doctor of a store finds what file systems do wrong, on one machine and between two."""

import itertools
import os
import time
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor

import pytest

from hairpipe.engine.store import doctor, doctor_pair
from hairpipe.engine.store.doctor import diagnose
from hairpipe.engine.store.doctor_pair import diagnose_pair
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store")


def verdicts(findings):
    return {finding.check: finding.verdict for finding in findings}


def refuse(*given):
    raise OSError(95, "Operation not supported")


FAULTS = {
    "exclusive creation": (doctor, "create", lambda path: path.touch() or True),
    "replacement": (doctor, "is_one", lambda path: False),
    "links": (os, "link", refuse),
    "locks": (doctor, "locked", lambda handle: True),
    "renewal": (os, "utime", lambda *given: None),
    "listing": (doctor, "names_in", lambda folder: set()),
    "leases": (Leases, "acquire", lambda leases, key: True),
    "space": (doctor, "LITTLE", 1e30),
}


def test_a_folder_of_this_machine_does_everything(store):
    found = verdicts(diagnose(store))
    assert set(found.values()) == {"ok"} and found.keys() >= FAULTS.keys()
    assert not [path for path in store.root.rglob("*") if path.is_file()]


@pytest.mark.parametrize("check", FAULTS)
def test_a_fault_is_found_and_named(store, check, monkeypatch):
    place, name, wrong = FAULTS[check]
    monkeypatch.setattr(place, name, wrong)
    monkeypatch.setattr(doctor, "SLOW", 0.01)
    found = verdicts(diagnose(store))
    harmless = check in ("links", "locks", "listing", "space")
    assert found.pop(check) == ("note" if harmless else "fault")
    assert set(found.values()) == {"ok"}


def test_read_only_users_are_reported(store, monkeypatch):
    store.room(store.temporary / "any")
    monkeypatch.setattr(os, "access", lambda path, mode: not mode & os.W_OK)
    assert verdicts(diagnose(store)) == {"folder": "ok", "writing": "note"}


def test_folders_that_are_closed_to_the_user_are_counted(store, monkeypatch):
    store.room(store.object_path("ab" * 20 + ".bin"))
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: path.name != "ab" and access(path, mode))
    finding = next(finding for finding in diagnose(store) if finding.check == "permissions")
    assert finding.verdict == "fault" and finding.result == "1 of 3 folders not writable"


def test_the_time_to_write_is_that_of_the_flush(tmp_path, monkeypatch):
    monkeypatch.setattr(doctor, "flush", lambda path: time.sleep(0.01))
    begun = time.perf_counter()
    _, result = doctor.write_through(tmp_path)
    assert result.endswith(" ms") and 9.9 < float(result.split()[0]) < 1e3 * (time.perf_counter() - begun) + 0.1


def pair(store):
    """Let two machines meet, each a thread; returns what each has found."""
    with ThreadPoolExecutor(2) as machines:
        return [machine.result() for machine in [machines.submit(lambda: [*diagnose_pair(store)]) for _ in range(2)]]


def test_two_machines_come_to_the_same_findings(store):
    one, other = pair(store)
    assert one == other and set(verdicts(one).values()) == {"ok"}
    assert set(verdicts(one)) == set(doctor_pair.CHECKS)
    assert not (store.root / "doctor").exists()
    assert not [path for path in store.root.rglob("*") if path.is_file()]


def test_two_machines_meet_though_files_are_found_half_written(store, monkeypatch):
    read = doctor_pair.Partner._read
    turns = defaultdict(itertools.count)
    monkeypatch.setattr(
        doctor_pair.Partner, "_read", lambda own, path: None if next(turns[own]) % 2 else read(own, path)
    )
    monkeypatch.setattr(doctor_pair, "CHECKS", {"links": doctor_pair.link_file})
    one, other = pair(store)
    assert one == other and set(verdicts(one).values()) == {"ok"}


@pytest.mark.parametrize(
    "check", ["exclusive creation", "replacement", "links", "locks", "renewal", "listing", "leases"]
)
def test_a_fault_between_two_machines_is_found(store, check, monkeypatch):
    place, name, wrong = FAULTS[check]
    place = doctor_pair if place is doctor else place
    if check == "renewal":
        place, name, wrong = doctor_pair.renewal, "renew", lambda: None
        monkeypatch.setattr(doctor_pair, "EXPIRY", 0.9)
    monkeypatch.setattr(doctor_pair, "SLOW", 0.01 if check == "listing" else 60.0)

    late = "renewal" if check == "leases" else check  # of a lease that nobody has
    run, delay = doctor_pair.CHECKS[late], doctor_pair.DELAY

    def give_up_soon(partner):
        """Wait for a short time in this check alone: a busy machine is late in any."""
        doctor_pair.DELAY = 0.5
        try:
            return run(partner)
        finally:
            doctor_pair.DELAY = delay

    if late in ("listing", "renewal"):
        monkeypatch.setitem(doctor_pair.CHECKS, late, give_up_soon)
    monkeypatch.setattr(place, name, wrong)
    one, other = pair(store)
    assert one == other and verdicts(one)[check] != "ok"
    assert {name for name, verdict in verdicts(one).items() if verdict != "ok"} == {check}


def test_alone_it_ends_with_a_message_whoever_was_there_before(store, monkeypatch):
    monkeypatch.setattr(doctor_pair, "PATIENCE", 0.3)
    folder = store.room(store.root / "doctor" / "any").parent
    (folder / ".hairpipe-other.tmp").write_text('{"host": "gone", "beat": 1, "said": [], "with": ""}')
    with pytest.raises(BadInput, match="a second machine does not answer"):
        list(diagnose_pair(store))
