"""Cost of the engine: what is counted and compared; no time is asserted."""

import importlib.util

import pytest

from hairpipe.bench import dask_cluster, engine
from hairpipe.bench.engine import Sizes, difference, measure_engine
from hairpipe.bench.toy_shot import EACH, SCAN, ToyRun, toy_shot
from hairpipe.errors import BadInput

SIZES = Sizes(tasks=(2, 5), scan_frames=(2, 4), warm=3, repeats=1)


def values_of(cases, *columns):
    """Pick columns of cases."""
    return [tuple(case[name] for name in columns) for case in cases]


@pytest.mark.slow
def test_report_counts_the_evaluations_of_each_engine():
    """That of Dask is left out where Dask is not installed."""
    with_dask = importlib.util.find_spec("distributed") is not None
    lines = []
    report = measure_engine(lines.append, 2, with_dask=with_dask, sizes=SIZES)
    engines = ["local", "dask"] if with_dask else ["local"]
    assert values_of(report.tables["one more"], "engine", "one more", "from", "to") == [
        row for name in engines for row in ((name, "task", 3, 6), (name, "scan frame", 3, 5))
    ]
    assert values_of(report.tables["coordinator"], "engine", "evaluated") == [
        (name, count) for name in engines for count in (3, 6)
    ]
    assert values_of(report.tables["re-run"], "cached", "evaluated") == [(7, 0)]
    assert report.module == engine.__name__ and lines[-1] == "re-run"


@pytest.mark.slow
def test_times_and_memory_are_those_of_the_coordinator():
    """The run takes less than its process; what the parent of that process has had counts for nothing."""
    ballast = b"x" * 400_000_000
    with toy_shot(2) as shot:
        found = shot.run((EACH, SCAN), 1)
    del ballast
    assert (found.evaluated, found.cached) == (5, 0)
    assert 0.0 < found.run < found.process
    assert found.memory is None or 10.0 < found.memory < 300.0


def test_one_more_is_the_slope_between_two_sizes():
    """Of 0.5 s, 2 s in a disturbed run, and 1 s for ten evaluations more."""
    pairs = [(ToyRun(3, 0, 4.0, 9.0, 1.0), ToyRun(13, 0, 4.0 + more, 9.0, 1.0)) for more in (0.5, 2.0, 1.0)]
    assert difference(pairs) == pytest.approx(
        {"from": 3, "to": 13, "median [ms]": 100.0, "minimum [ms]": 50.0, "maximum [ms]": 200.0}
    )


def test_a_run_that_fails_is_one_message(capfd):
    with toy_shot(2) as shot:
        (shot.folder / "nodes" / "toy_each.py").unlink()
        with pytest.raises(BadInput, match="the run of toy nodes failed"):
            shot.run((EACH,), 1)
    assert "toy_each" in capfd.readouterr().err


def test_absent_dask_is_named(monkeypatch):
    monkeypatch.setattr(dask_cluster.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(BadInput, match="Dask is not installed"):
        measure_engine(lambda line: None, 1, with_dask=True, sizes=SIZES)


def test_a_scheduler_that_does_not_start_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(dask_cluster, "PATIENCE", 0.0)
    with pytest.raises(BadInput, match="no Dask scheduler starts"):
        dask_cluster.address_in(tmp_path / "absent.json")
