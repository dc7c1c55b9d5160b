"""The benches `calls` and `schedules`: they find what is wrong, and that nothing is, in short."""

import os
import random

import pytest

from hairpipe.engine.store.lease import Leases
from hairpipe.formats.hdf5 import digest_file
from hairpipe.graphs.experiments.bench.calls.call_trials import DISTURBANCES, held, try_calls
from hairpipe.graphs.experiments.bench.calls.file_layer import Call, FileLayer
from hairpipe.graphs.experiments.bench.calls.schedules import Turns, try_schedules


def quiet(line):
    pass


def forget_leases(monkeypatch):
    """Break the code: no lease is given back."""
    monkeypatch.setattr(Leases, "release", lambda leases, key: None)
    monkeypatch.setattr(Leases, "sweep", lambda leases: [])


@pytest.fixture
def layer(tmp_path):
    calls = []
    (tmp_path / "in").mkdir()
    with FileLayer((tmp_path / "in",), calls.append):
        yield calls


def test_layer_sees_calls_on_files_of_its_folder_alone(layer, tmp_path):
    (tmp_path / "in" / "a").write_text("a")
    (tmp_path / "a").write_text("a")
    (tmp_path / "in" / "a").replace(tmp_path / "in" / "b")
    handle = os.open(tmp_path / "in" / "b", os.O_RDONLY)
    os.fsync(handle)
    os.close(handle)
    folder = os.open(tmp_path / "in", os.O_RDONLY)
    os.unlink("b", dir_fd=folder)
    os.close(folder)
    assert layer == [
        Call("open file", "a", True),
        Call("replace", "a", True, "b"),
        Call("open", "b", False),
        Call("fsync", "b", True),
        Call("open", "", False),
        Call("unlink", "b", True),
    ]


def test_layer_is_gone_in_the_end(tmp_path):
    before = os.stat, open
    with FileLayer((tmp_path,), quiet):
        assert (os.stat, open) != before
    assert (os.stat, open) == before


def test_runs_withstand_faults_at_calls_and_a_lease_that_stays_is_found(monkeypatch):
    report = try_calls(quiet, digest_file, every=600)
    assert held(report), report.tables["violations"]
    assert [case["disturbance"] for case in report.tables["disturbances"]] == list(DISTURBANCES)
    assert report.tables["disturbances"][0]["killed"] > 0
    forget_leases(monkeypatch)
    report = try_calls(quiet, digest_file, every=10_000)
    assert not held(report) and "is left" in report.tables["violations"][0]["violation"]


def test_two_coordinators_share_the_work_and_a_lease_that_stays_is_found(monkeypatch):
    report = try_schedules(quiet, digest_file, range(4))
    assert held(report), report.tables["violations"]
    assert {case["schedules"] for case in report.tables["schedules"]} == {"two coordinators", "one of them killed"}
    forget_leases(monkeypatch)
    report = try_schedules(quiet, digest_file, range(1))
    assert not held(report) and "is left" in report.tables["violations"][0]["violation"]


def drawn(seed):
    """Draw an order of 3 threads with 20 steps each."""
    turns = Turns(random.Random(seed), 0.5)
    order = []

    def work(thread):
        for _ in range(20):
            order.append(thread)
            turns.step()

    turns.run(work, 3)
    return order


def test_a_seed_gives_one_order():
    assert drawn(1) == drawn(1) != drawn(2)
    assert sorted(drawn(1)) == sorted([0, 1, 2] * 20)
