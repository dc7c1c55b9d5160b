"""Times of repeated runs."""

import pytest

from hairpipe.graphs.experiments.bench.repeat import LEAST_RUNS, Spread, repeat


def test_the_first_run_and_preparing_do_not_count(monkeypatch):
    calls, clock = [], [0]

    def work():
        calls.append("work")
        clock[0] += 2000 if len(calls) <= 2 else len(calls) // 2

    def prepare():
        calls.append("prepare")
        clock[0] += 100

    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    spread = repeat(work, 0.0, prepare)
    assert calls == ["prepare", "work"] * (LEAST_RUNS + 1)
    assert spread == Spread(median=4.0, low=3.0, high=5.0, runs=LEAST_RUNS)


def test_a_time_becomes_a_time_per_thing_or_a_rate():
    spread = Spread(2.0, 1.0, 4.0, 7)
    assert spread.per(2) == (1.0, 0.5, 2.0, 7)
    assert spread.rate(8) == (4.0, 2.0, 8.0, 7)
    assert spread.rate(8).low == pytest.approx(8 / spread.high)


def test_columns_carry_the_unit():
    assert Spread(2.0, 1.0, 4.0, 7).columns(" [ns]") == {"median [ns]": 2.0, "low [ns]": 1.0, "high [ns]": 4.0}
