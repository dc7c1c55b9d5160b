"""Runs of a part of the frames: each result is that of the whole shot, in any order of runs."""

import itertools
import shutil

import pytest

from hairpipe.engine.plan.tasks import collectors
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput

DRAWN = """
[soft]
type = "soften"
in.number = "sum"
[drawn]
type = "draw_number"
in.number = "sum"
publish = "out/drawn.##.txt"
"""
TOTAL = '[total]\ntype = "gather"\nin.numbers = "seed"\nin.shots = "sum"\n'
ABOVE = '[above]\ntype = "soften"\nin.number = "move"\nin.other = "total"\n'


@pytest.fixture
def branched(shot):
    """A shot of six frames with a scan, files per frame and of all frames, and a table over frames."""
    text = shot.path.read_text().replace("[1, 10]", "[1, 6]").replace('in.numbers = "sum"', 'in.numbers = "soft"')
    shot.path.write_text(text + DRAWN + TOTAL)
    return shot


def run_only(shot, only, **settings):
    """Run a part of the frames of a shot."""
    return run(shot.load(), shot.store, None, Options(jobs=1, only=only, **settings))


def published(shot):
    """Bytes of the published files, by name."""
    return {path.name: path.read_bytes() for path in sorted((shot.folder / "out").iterdir())}


@pytest.fixture
def whole(branched, known):
    """Published files, counts and results of a run of the whole shot that nobody disturbs, which is made once."""
    if "branched" not in known:
        other = Store(branched.folder / "undisturbed")
        branched.run(store=other)
        known["branched"] = published(branched), branched.tally(), branched.results(store=other)
        shutil.rmtree(branched.folder / "out")
    return known["branched"]


CHUNKS = [(1, 2), (3, 4), (5, 6)]


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_chunks_in_any_order_give_the_shot_and_nothing_twice(branched, whole, order):
    for place, number in enumerate(order):
        assert not (branched.folder / "out" / "list.txt").exists(), "not all frames are there"
        outcome = run_only(branched, CHUNKS[number])
        assert outcome.exit_code == 0 and outcome.failures == () and outcome.blocked == 0
        drawn = [path for path in outcome.published if "drawn" in path]
        assert len(drawn) == 2 and (place == 2) == any("list" in path for path in outcome.published)
    assert (published(branched), branched.tally(), branched.results()) == whole


def test_a_file_of_all_frames_is_never_one_of_a_part(branched):
    """Chunks by --frames make it of their own frames, and the last one stays: --only does not."""
    run(branched.load(), branched.store, (1, 2), Options(jobs=1))
    assert len((branched.folder / "out" / "list.txt").read_text().splitlines()) == 2
    for only in CHUNKS:
        run_only(branched, only)
    assert len((branched.folder / "out" / "list.txt").read_text().splitlines()) == 6


def test_a_frame_that_needs_all_frames_is_reported_as_not_reached(branched):
    branched.add(ABOVE)
    outcome = run_only(branched, (1, 2))
    assert (outcome.exit_code, outcome.blocked, outcome.failures) == (1, 2, ())
    assert [run_only(branched, only).exit_code for only in ((3, 4), (5, 6), (1, 2), (3, 4))] == [1, 0, 0, 0]
    assert branched.tally()["gather"] == 1


def test_frames_outside_of_the_run_are_refused_and_collectors_are_what_sees_frames(branched):
    with pytest.raises(BadInput, match="--only: frame 7 is not a frame of the run"):
        run_only(branched, (6, 7))
    branched.add(ABOVE)
    assert sorted(collectors(branched.load())) == ["list", "total"]


def test_a_run_waits_so_long_for_others_and_ends_with_75(branched):
    """A process that holds the lease of the first result computes nothing: the run waits in vain, or until it ends."""
    entry = branched.plan()["seed"]
    leases = Leases(branched.store)
    branched.store.root.mkdir()
    assert leases.acquire(entry.key)
    outcome = run_only(branched, (1,), wait=0.2)
    assert (outcome.exit_code, outcome.leased, outcome.evaluated) == (75, 1, 0)
    started = []

    def end_at_the_second_try(event):
        started.extend([event.task] if event.kind == "started" else [])
        if len(started) == 2:
            leases.release(entry.key)

    options = Options(jobs=1, only=(1,), wait=60.0)
    outcome = run(branched.load(), branched.store, None, options, end_at_the_second_try)
    assert outcome.exit_code == 0 and started[0] == started[1] == entry.task
