"""Phases of the first frame of a worker."""

import pytest

from hairpipe.graphs.experiments.bench.engine.first_frame import (
    IMPORTS,
    NUMBA,
    PYTHON,
    SECOND,
    Clock,
    measure_first_frame,
)


def test_a_phase_is_counted_without_the_phases_within_it(monkeypatch):
    now = iter([0.0, 1.0, 3.0, 7.0])
    monkeypatch.setattr("time.process_time", lambda: next(now))
    clock = Clock()
    with clock.phase("outer"):
        clock.counted("inner", lambda: None)()
    assert clock.seconds == {"outer": 5.0, "inner": 2.0}


@pytest.mark.slow
def test_a_new_process_is_measured(shot):
    cases = measure_first_frame(shot.path, {}, "sum").tables["phases"]
    phases = {case["phase"]: case["processor [s]"] for case in cases}
    assert phases[PYTHON] > 0 and phases[NUMBA] > 0
    assert {IMPORTS, SECOND} <= phases.keys()
