"""Times of repeated runs."""

import time

import pytest

from hairpipe.bench.repeat import LEAST_RUNS, Spread, repeat


def test_the_first_run_and_preparing_do_not_count():
    calls = []

    def work():
        calls.append("work")
        time.sleep(0.2 if len(calls) <= 2 else 0.001)

    def prepare():
        calls.append("prepare")
        time.sleep(0.01)

    spread = repeat(work, 0.0, prepare)
    assert calls == ["prepare", "work"] * (LEAST_RUNS + 1)
    assert spread.runs == LEAST_RUNS
    assert 0.001 <= spread.low <= spread.median <= spread.high
    assert spread.low < 0.01


def test_a_time_becomes_a_time_per_thing_or_a_rate():
    spread = Spread(2.0, 1.0, 4.0, 7)
    assert spread.per(2) == (1.0, 0.5, 2.0, 7)
    assert spread.rate(8) == (4.0, 2.0, 8.0, 7)
    assert spread.rate(8).low == pytest.approx(8 / spread.high)
