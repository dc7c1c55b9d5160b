"""The report on the strand core."""

import numba
import pytest

from hairpipe.graphs.experiments.bench import core
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work
from hairpipe.graphs.experiments.bench.repeat import Spread
from hairpipe.graphs.experiments.bench.roofs import Roofs

TINY = {"segments": 4, "cached": 9, "stored": 17, "triad": 1 << 12, "seconds": 0.0}


def test_the_least_time_is_that_of_the_tighter_roof():
    """On 1e9 operations and 2e9 bytes a second, and twice the operations with two threads."""
    roofs = Roofs({"float64": Spread(1e9, 1e9, 1e9, 1)}, {n: Spread(2e9, 2e9, 2e9, 1) for n in (1, 2)})
    work = Work(operations=100, bytes=300)
    assert core.least_time(work, "float64", "cache", 1, roofs) == pytest.approx(100)
    assert core.least_time(work, "float64", "cache", 2, roofs) == pytest.approx(50)
    assert core.least_time(work, "float64", "memory", 1, roofs) == pytest.approx(150)


def test_every_case_is_measured_once(monkeypatch):
    monkeypatch.setattr(core, "MODELS", ("network",))  # others would be compiled for nothing else
    reported = []
    before = numba.get_num_threads()
    report = core.measure_core(reported.append, **TINY)
    assert numba.get_num_threads() == before
    threads = [n for n in core.THREADS if n <= before]
    kernels = report.tables["kernels"]
    cases = [tuple(case[name] for name in ("kernel", "in", "numbers", "threads")) for case in kernels]
    assert len(set(cases)) == len(cases) == 2 * 2 * 2 * len(threads)
    for case in kernels:
        median, low, high = (case[f"{name} [ns a particle]"] for name in ("median", "low", "high"))
        assert 0 < low <= median <= high and case["each segment [ns]"] == pytest.approx(median * 11 / 4)
        assert ("floor [ns a particle]" in case) == (case["kernel"] == "solve")
    single, double = report.tables["solves"]
    assert double["flop a particle"] == single["flop a particle"]
    assert double["bytes a particle"] == 2 * single["bytes a particle"]
    assert report.machine.cores >= 1
    assert report.bandwidth > 0 and len(report.tables["limits"]) == 2 + len(threads)
    assert "17 strands of the network in float32" in reported
