"""Workers that stay between runs: the same processes, as long as they are what new ones would be."""

import signal

import pytest

from hairpipe.engine.hosts.host import LocalEngine, Member, Slots
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.plain_file import stamp_of

from ..conftest import NO_JOB, local_engine


@pytest.fixture
def spare():
    """A list of idle workers, which end with the test."""
    members: list[Member] = []
    yield members
    for member in members:
        member.end()


def run_with(shot, spare: list[Member], **settings) -> set[int]:
    """Run a shot with workers that stay; returns the ids of their processes."""
    outcome = run(shot.load(**settings), shot.store, None, Options(jobs=1, spare=spare))
    assert outcome.exit_code == 0 and outcome.evaluated > 0
    return {member.process.pid for member in spare}


def test_workers_stay_between_runs_and_give_what_new_ones_give(shot, spare):
    before = run_with(shot, spare)
    assert run_with(shot, spare, seed__value=4) == before and len(before) == 2
    other = Store(shot.folder / "other")
    shot.run(store=other, seed__value=4)
    assert shot.results(seed__value=4) == shot.results(store=other, seed__value=4)


def test_scans_at_a_time_share_the_threads(shot, spare):
    shot.add('[other]\nlike = "sum"\nin.number = "moved"\n')
    shot.add('[moved]\nlike = "move"\nstep = 2.0\n')
    whole = Store(shot.folder / "whole")
    shot.run(store=whole)
    counts, running, most = shot.tally(), set(), 0
    shot.run(to=["move", "moved"])  # so that both scans are ready at once

    def watch(event):
        nonlocal most
        if event.task and event.task.node in ("sum", "other"):
            running.add(event.task) if event.kind == "started" else running.discard(event.task)
            most = max(most, len(running))

    run(shot.load(), shot.store, None, Options(jobs=4, scans=2, spare=spare), watch)
    assert most == 2 and shot.tally() == counts and shot.results() == shot.results(store=whole)
    assert [member.environment["NUMBA_NUM_THREADS"] for member in spare if member.wide] == ["2", "2"]


def test_workers_of_other_sources_or_of_another_store_and_dead_ones_are_replaced(shot, spare):
    before = run_with(shot, spare)
    shot.edit("numeral.py", "load: np.ndarray", "load: np.ndarray | None")
    edited = run_with(shot, spare)
    assert not edited & before
    for member in spare:
        member.process.kill()
        member.process.wait()
    dead = run_with(shot, spare, seed__value=4)
    assert not dead & edited
    shot.store = Store(shot.folder / "other")
    assert not run_with(shot, spare) & dead


def test_a_worker_that_is_evaluating_ends_with_the_run(shot, spare):
    engine = local_engine(shot, spare)
    engine.submit(NO_JOB)
    (member,) = engine.host.members
    engine.close()
    assert not spare and member.process.poll() is not None


def test_a_run_without_a_slot_for_a_scan_fails_and_names_it(shot, monkeypatch):
    """All machines that simulate may be lost between two frames."""
    monkeypatch.setattr(LocalEngine, "slots", lambda engine: Slots(0, 2 - len(engine.host.busy)))
    outcome = shot.run(jobs=2)
    (failure,) = outcome.failures
    assert str(failure) == "sum@1: no machine offers a slot for this node: start one, and run again"
    assert outcome.exit_code == 1 and shot.tally() == {"make_seed": 1, "move_seed": 10}


def test_a_new_worker_replaces_an_old_one_unless_sources_were_edited(shot, spare):
    files = [shot.folder / name for name in ("one.py", "other.py", "edited.py")]
    for file in files:
        file.write_text("")
    one, other, edited = ({str(file): stamp_of(str(file))} for file in files)
    for sources in (one | edited, other):
        engine = local_engine(shot, spare, sources)
        engine.submit(NO_JOB)
        assert [reply["key"] for reply in engine.replies(None)] == [NO_JOB.key]
        engine.close()
        files[2].write_text("edited")
    (member,) = spare
    assert one.keys() | other.keys() <= member.hello["sources"].keys()
    assert str(files[2]) not in member.hello["sources"]


def test_ctrl_c_while_a_worker_starts_does_not_reach_it(shot):
    engine = local_engine(shot)
    engine.submit(NO_JOB)
    engine.host.members[0].process.send_signal(signal.SIGINT)
    (reply,) = engine.replies(None)
    engine.close()
    assert reply["failure"]["message"].startswith("no node type")
