"""Processes that compute have the threading layer that we choose, whatever libraries are installed."""

import json
import os
import subprocess

import pytest

from hairpipe import child
from hairpipe.engine.hosts.host import environment
from hairpipe.engine.worker import threading_layer
from hairpipe.engine.worker.threading_layer import (
    NAME,
    ORDER,
    SPIN,
    THREADS,
    WAITING,
    choose_layer,
    is_loadable,
    usable_cores,
)
from hairpipe.errors import BadInput

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
    for name in (NAME, ORDER, *WAITING):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def installed(monkeypatch):
    """Pretend that these layers can be loaded."""
    return lambda *names: monkeypatch.setattr(threading_layer, "is_loadable", names.__contains__)


def test_workers_compute_with_our_layer_whose_threads_sleep_and_calls_stay_as_cheap():
    """After 20,000 others; numba would try TBB first, of which a version costs 10 times as much by then."""
    told = environment(2, {}) | {"OMP_DISPLAY_ENV": "VERBOSE"}
    done = subprocess.run(child.command(CALLS), env=told, check=True, capture_output=True)
    before, used, order, (early, late) = json.loads(done.stdout)
    assert before is None and used == order[0] == choose_layer().name
    assert used == "omp" or not is_loadable("omp")
    assert late < 3 * early
    if b"GOMP" in done.stderr:
        assert f"GOMP_SPINCOUNT = '{SPIN['GOMP_SPINCOUNT']}'" in done.stderr.decode()


def test_openmp_is_chosen_then_that_of_numba(installed):
    for names, order in (
        (("omp", "tbb", "workqueue"), "omp workqueue tbb"),
        (("tbb", "workqueue"), "workqueue tbb omp"),
        (("tbb",), "tbb omp workqueue"),
    ):
        installed(*names)
        assert choose_layer() == (order.split()[0], SPIN | {ORDER: order})


def test_a_named_layer_is_used(installed, monkeypatch):
    installed("omp", "tbb", "workqueue")
    for variable, value in ((NAME, "tbb"), (ORDER, "tbb omp workqueue"), (NAME, "workqueue")):
        with monkeypatch.context() as patch:
            patch.setenv(variable, value)
            assert choose_layer() == (value.split()[0], SPIN)


@pytest.mark.parametrize("variable", sorted(WAITING))
def test_threads_wait_as_the_user_says(variable, monkeypatch):
    assert SPIN.items() <= environment(2, {}).items()
    monkeypatch.setenv(variable, "7")
    assert environment(2, {})[variable] == "7" and not SPIN.items() & environment(2, {}).items()


@pytest.mark.parametrize(("quota", "cores"), [("150000 100000", 2), ("50000 100000", 1), ("max 100000", 8), (None, 8)])
def test_cores_are_those_that_a_process_is_given(quota, cores, tmp_path, monkeypatch):
    monkeypatch.delenv(THREADS, raising=False)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: range(8), raising=False)
    monkeypatch.setattr(threading_layer, "QUOTA", tmp_path / "cpu.max")
    if quota is not None:
        (tmp_path / "cpu.max").write_text(quota + "\n")
    assert usable_cores() == cores


def test_a_user_names_the_number_of_threads(monkeypatch):
    monkeypatch.setenv(THREADS, "3")
    assert usable_cores() == 3
    for wrong in ("", "0", "-1", "two"):
        monkeypatch.setenv(THREADS, wrong)
        with pytest.raises(BadInput, match=f"^NUMBA_NUM_THREADS: '{wrong}' is no number of threads .a whole number"):
            usable_cores()
