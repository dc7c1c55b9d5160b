"""Processes that compute have the threading layer that we choose, whatever libraries are installed."""

import json
import subprocess

import pytest

from hairpipe import child
from hairpipe.engine.hosts.member import environment
from hairpipe.engine.worker import threading_layer
from hairpipe.engine.worker.threading_layer import NAME, ORDER, CallCost, choose_layer, is_loadable

CALLS = """
import json, numba
from hairpipe.engine.worker.threading_layer import layer_in_use
from hairpipe.engine.worker.threading_layer import measure_calls
before = layer_in_use()
costs = measure_calls(500, 20_000)
print(json.dumps([before, layer_in_use(), numba.config.THREADING_LAYER_PRIORITY, costs]))
"""


@pytest.fixture(autouse=True)
def nothing_told(monkeypatch):
    for name in (NAME, ORDER):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def installed(monkeypatch):
    """Pretend that these layers can be loaded, and that their calls cost so much."""

    def install(**costs):
        monkeypatch.setattr(threading_layer, "is_loadable", costs.__contains__)
        monkeypatch.setattr(threading_layer, "cost_of", costs.get)

    return install


def test_workers_compute_with_our_layer_and_their_calls_stay_as_cheap():
    """After 20,000 others; numba would try TBB first, of which a version costs 10 times as much by then."""
    done = subprocess.run(child.command(CALLS), env=environment(2, {}), check=True, stdout=subprocess.PIPE)
    before, used, order, (early, late) = json.loads(done.stdout)
    assert before is None and used == order[0] == choose_layer().name
    assert used == "omp" or not is_loadable("omp")
    assert late < 3 * early


def test_without_openmp_the_layer_with_the_cheapest_calls_is_chosen(installed):
    installed(omp=None, tbb=None, workqueue=None)
    assert choose_layer() == ("omp", {ORDER: "omp tbb workqueue"}, ""), "nothing is measured"
    installed(tbb=CallCost(2.0, 2.0), workqueue=CallCost(50.0, 50.0))
    assert choose_layer() == ("tbb", {ORDER: "tbb workqueue omp"}, "")
    installed(tbb=CallCost(9.0, 90.0), workqueue=CallCost(50.0, 50.0))
    assert choose_layer() == ("workqueue", {ORDER: "workqueue tbb omp"}, "")
    installed(workqueue=None)
    assert choose_layer() == ("workqueue", {ORDER: "workqueue omp tbb"}, "")


def test_a_forced_threading_layer_is_used_with_a_warning_for_slow_calls(installed, monkeypatch):
    installed(omp=None, tbb=CallCost(9.5, 78.0), workqueue=None)
    for variable, value in ((NAME, "tbb"), (ORDER, "tbb omp workqueue")):
        with monkeypatch.context() as patch:
            patch.setenv(variable, value)
            name, settings, warning = choose_layer()
        assert name == "tbb" and settings == {} and "from 9.5 to 78 us" in warning
    monkeypatch.setenv(NAME, "workqueue")
    assert choose_layer() == ("workqueue", {}, "")
    monkeypatch.setenv(NAME, "tbb")
    installed(tbb=CallCost(2.0, 2.1))
    assert choose_layer() == ("tbb", {}, "")


def test_a_run_says_that_calls_of_a_named_layer_grow_dearer(shot, installed, monkeypatch):
    installed(tbb=CallCost(9.5, 78.0))
    monkeypatch.setenv(ORDER, "tbb omp workqueue")
    warned = []
    outcome = shot.run(to=["move"], report=lambda event: warned.append(event))
    assert outcome.exit_code == 0
    assert [event.message for event in warned if event.kind == "warning"] == [choose_layer().warning]


def test_the_cost_of_a_layer_is_measured_once(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    begun = []

    class Done:
        stdout = "[3.0, 4.0]"

    monkeypatch.setattr(subprocess, "run", lambda *_, env, **__: begun.append(env[NAME]) or Done)
    threading_layer.cost_of.cache_clear()
    for _ in range(2):
        assert threading_layer.cost_of("workqueue") == CallCost(3.0, 4.0)
        threading_layer.cost_of.cache_clear()
    assert begun == ["workqueue"]
