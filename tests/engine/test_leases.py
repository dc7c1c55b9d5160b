"""Runs that share a store, on file systems whose locks are of one machine alone, and on machines that cannot look each
other's processes up.
"""

import shutil
import signal
import time

import pytest

from hairpipe.engine.store import holder, lease
from hairpipe.engine.store.atomic import workspace

from .conftest import wait_for

SLOW = '[slow]\ntype = "go_wrong"\nin.number = "move"\nhow = "slow"\nat = 1\n'
PLAIN = {"make_seed": 1, "move_seed": 10, "add_up": 10, "write_list": 1}


@pytest.fixture
def elsewhere(monkeypatch):
    """Be a machine from which no process of the runs of tests can be looked up, with a patience of two seconds."""
    monkeypatch.setattr(holder, "machine", lambda: "0123456789ab")
    monkeypatch.setattr(lease, "EXPIRY", 2.0)


def test_a_run_that_starts_takes_nothing_from_one_that_is_computing(shot, elsewhere, monkeypatch):
    """Neither its workspaces nor its leases, though no lock protects them, and the clock is off by hours."""
    clock = time.time
    monkeypatch.setattr(time, "time", lambda: clock() + 7 * 3600)
    with monkeypatch.context() as other, workspace(shot.store.temporary) as live:
        other.setattr(holder, "machine", lambda: "ba9876543210")
        (live / "half").write_text("")
        assert shot.store.sweep() == 0 and (live / "half").exists()
    assert not live.exists()


@pytest.mark.slow
def test_two_runs_on_machines_that_know_nothing_of_each_other_share_the_work(shot):
    outcomes = [shot.outcome(process) for process in [shot.start(jobs=1, TOY_MACHINE=name) for name in "ab"]]
    assert [outcome["failures"] for outcome in outcomes] == [[], []]
    assert shot.tally() == PLAIN and sum(outcome["evaluated"] for outcome in outcomes) == 22
    assert list((shot.store.root / "lease").iterdir()) == []


def test_links_to_nothing_in_place_of_leases_cost_no_time_and_are_named(shot):
    shot.run()
    keys = list(shot.store.record_keys())
    shutil.rmtree(shot.store.root / "actions")
    for key in keys:
        (shot.store.root / "lease" / key).symlink_to("nowhere")
    shot.tally()
    begun = time.monotonic()
    assert shot.run().exit_code == 0 and shot.tally() == PLAIN and time.monotonic() - begun < 30.0
    ((_, warning),) = shot.warned
    assert warning.startswith("22 damaged leases were removed, the first /")
    assert list((shot.store.root / "lease").iterdir()) == []


@pytest.fixture
def slow(shot, monkeypatch):
    """Start a run that waits in an evaluation until its gate is there, which nobody else waits for."""
    shot.add(SLOW)
    process = shot.start(jobs=1, TOY_GATE=str(shot.folder / "gate"))
    wait_for(lambda: shot.has_called("go_wrong 1"))
    monkeypatch.setenv("TOY_GATE", str(shot.path))
    yield process
    process.kill()
    process.communicate()


@pytest.mark.slow
def test_the_work_of_a_machine_that_is_lost_is_taken_over(shot, slow, elsewhere):
    slow.kill()
    slow.communicate()
    assert shot.run().failures == ()
    assert shot.tally()["go_wrong"] == 11, "only what it was computing is computed again"
    states = {found["state"].removesuffix(".h5") for name, found in shot.results().items() if name.startswith("sum")}
    left = {path.name for path in (shot.store.root / "lease").iterdir()}
    assert left <= states, "those of states that were in its memory are swept after a day"


@pytest.mark.slow
def test_a_machine_that_was_only_slow_finishes_and_changes_nothing(shot, slow, elsewhere):
    slow.send_signal(signal.SIGSTOP)
    assert shot.run().failures == ()
    results = shot.results()
    (shot.folder / "gate").touch()
    slow.send_signal(signal.SIGCONT)
    assert shot.outcome(slow)["failures"] == [] and shot.results() == results
    assert shot.tally()["go_wrong"] == 11
    assert list((shot.store.root / "lease").iterdir()) == []


@pytest.mark.slow
def test_after_a_kill_a_run_of_the_same_machine_waits_for_nothing(shot, slow):
    slow.kill()
    slow.communicate()
    assert shot.run().failures == () and shot.tally()["go_wrong"] == 11
