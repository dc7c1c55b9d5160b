"""The checks of the folder of a store find what its file system, its owners and its disk do wrong."""

import os

import pytest

from hairpipe.engine.plan import maintenance
from hairpipe.engine.plan.maintenance import diagnose
from hairpipe.engine.store import atomic
from hairpipe.engine.store.lease import EXPIRY, Leases
from hairpipe.engine.store.store import Store

KEY = "d0c7" * 10
GOOD = dict.fromkeys(["folder", "permissions", "space", "exclusive creation", "leases"], "ok")


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store")


def verdicts(findings):
    return {finding.check: finding.verdict for finding in findings}


def refuse(*given):
    raise OSError(95, "Operation not supported")


def test_a_folder_of_this_machine_does_everything(store):
    assert verdicts(diagnose(store)) == GOOD
    assert not [path for path in store.root.rglob("*") if path.is_file()]


@pytest.mark.parametrize(
    ("check", "name", "wrong", "verdict"),
    [
        ("exclusive creation", "create", lambda path: path.touch() or True, "fault"),
        ("exclusive creation", "create", refuse, "fault"),
        ("space", "LITTLE", 1e30, "note"),
    ],
)
def test_a_fault_is_found_and_named(store, check, name, wrong, verdict, monkeypatch):
    monkeypatch.setattr(maintenance, name, wrong)
    assert verdicts(diagnose(store)) == GOOD | {check: verdict}


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


def test_the_age_of_leases_is_that_of_the_one_renewed_first(store):
    leases = Leases(store)
    assert leases.acquire(KEY) and leases.acquire(KEY[::-1])
    *_, finding = diagnose(store)
    assert finding.verdict == "ok" and finding.result.startswith("2 held now, on ")
    path = store.root / "lease" / KEY
    long_ago = atomic.now_in(store.root) - 2 * EXPIRY
    os.utime(path, (long_ago, long_ago))
    *_, finding = diagnose(store)
    assert finding.verdict == "note" and finding.result.endswith("at most 120 s ago")
    leases.close()
    path.write_text("damaged")
    *_, finding = diagnose(store)
    assert finding.verdict == "ok" and finding.result == "0 held now"
