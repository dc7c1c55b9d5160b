"""Processes that compute have the threading layer that we choose, whatever libraries are installed."""

import json
import subprocess

import pytest

from hairpipe import child
from hairpipe.engine.hosts.host import environment
from hairpipe.engine.worker import threading_layer
from hairpipe.engine.worker.threading_layer import NAME, ORDER, choose_layer, is_loadable

CALLS = """
import json, time
import numba, numpy as np
from hairpipe.engine.worker.threading_layer import layer_in_use

@numba.njit(parallel=True)
def add_one(x):
    for i in numba.prange(len(x)):
        x[i] += 1.0

def median_cost(x):
    spent = []
    for _ in range(500):
        begun = time.perf_counter()
        add_one(x)
        spent.append(time.perf_counter() - begun)
    return float(np.median(spent))

before = layer_in_use()
x = np.zeros(2000)
add_one(x)
early = median_cost(x)
for _ in range(20_000):
    add_one(x)
print(json.dumps([before, layer_in_use(), numba.config.THREADING_LAYER_PRIORITY, [early, median_cost(x)]]))
"""


@pytest.fixture(autouse=True)
def nothing_told(monkeypatch):
    for name in (NAME, ORDER):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def installed(monkeypatch):
    """Pretend that these layers can be loaded, and that TBB has this version of its interface."""

    def install(*names, tbb=0):
        monkeypatch.setattr(threading_layer, "is_loadable", names.__contains__)
        monkeypatch.setattr(threading_layer, "tbb_version", lambda: tbb)

    return install


def test_workers_compute_with_our_layer_and_their_calls_stay_as_cheap():
    """After 20,000 others; numba would try TBB first, of which a version costs 10 times as much by then."""
    done = subprocess.run(child.command(CALLS), env=environment(2, {}), check=True, stdout=subprocess.PIPE)
    before, used, order, (early, late) = json.loads(done.stdout)
    assert before is None and used == order[0] == choose_layer().name
    assert used == "omp" or not is_loadable("omp")
    assert late < 3 * early


def test_openmp_is_chosen_then_a_recent_tbb_then_that_of_numba(installed):
    installed("omp", "tbb", "workqueue", tbb=12120)
    assert choose_layer() == ("omp", {ORDER: "omp tbb workqueue"}, "")
    installed("tbb", "workqueue", tbb=12120)
    assert choose_layer() == ("tbb", {ORDER: "tbb workqueue omp"}, "")
    installed("tbb", "workqueue", tbb=12110)
    assert choose_layer() == ("workqueue", {ORDER: "workqueue omp tbb"}, "")
    installed("workqueue")
    assert choose_layer() == ("workqueue", {ORDER: "workqueue omp tbb"}, "")


def test_a_forced_threading_layer_is_used_with_a_warning_for_an_old_tbb(installed, monkeypatch):
    installed("omp", "tbb", "workqueue", tbb=12080)
    for variable, value in ((NAME, "tbb"), (ORDER, "tbb omp workqueue")):
        with monkeypatch.context() as patch:
            patch.setenv(variable, value)
            name, settings, warning = choose_layer()
        assert name == "tbb" and settings == {} and "TBB of 2021.12" in warning
    monkeypatch.setenv(NAME, "workqueue")
    assert choose_layer() == ("workqueue", {}, "")
    monkeypatch.setenv(NAME, "tbb")
    installed("tbb", tbb=12120)
    assert choose_layer() == ("tbb", {}, "")
    installed("omp")
    assert choose_layer() == ("tbb", {}, "")


def test_numba_uses_no_tbb_below_its_own_limit(monkeypatch):
    monkeypatch.setattr(threading_layer, "tbb_version", lambda: threading_layer.OLDEST_TBB - 1)
    assert not is_loadable.__wrapped__("tbb")


def test_a_run_warns_of_a_named_layer_whose_calls_become_slower(shot, installed, monkeypatch):
    installed("tbb", tbb=12080)
    monkeypatch.setenv(ORDER, "tbb omp workqueue")
    assert shot.run(to=["move"]).exit_code == 0
    assert [message for _, message in shot.warned] == [choose_layer().warning]
