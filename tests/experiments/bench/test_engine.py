"""Cost of the engine: what is counted and compared; no time is asserted."""

import importlib.util
import tomllib
from contextlib import nullcontext

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.engine import dask_cluster, engine
from hairpipe.graphs.experiments.bench.engine.engine import Sizes, difference, measure_engine
from hairpipe.graphs.experiments.bench.engine.engine_shot import EACH, SCAN, ToyRun, ToyShot, toy_shot

SIZES = Sizes(tasks=(2, 5), scan_frames=(2, 4), warm=3, repeats=1)


def values_of(cases, *columns):
    """Pick columns of cases."""
    return [tuple(case[name] for name in columns) for case in cases]


def test_report_counts_the_evaluations_of_each_engine(monkeypatch):
    """The runs are not made: a shot has a value for all frames and one each; that of a re-run has both nodes."""
    asked = []

    def run(self, nodes, jobs, scheduler=None):
        asked.append(scheduler)
        first, last = tomllib.loads((self.folder / "shot.toml").read_text())["frames"]
        evaluated = 1 + len(nodes) * (last - first + 1)
        return ToyRun(evaluated, 0, 1.0, 2.0, 30.0) if len(nodes) == 1 else ToyRun(0, evaluated, 1.0, 2.0, 30.0)

    monkeypatch.setattr(ToyShot, "run", run)
    monkeypatch.setattr(engine, "dask_cluster", lambda jobs: nullcontext("tls://scheduler"))
    lines = []
    report = measure_engine(lines.append, 2, with_dask=True, sizes=SIZES)
    assert values_of(report.tables["one more"], "engine", "one more", "from", "to") == [
        row for name in ("local", "dask") for row in ((name, "task", 3, 6), (name, "scan frame", 3, 5))
    ]
    assert values_of(report.tables["coordinator"], "engine", "evaluated") == [
        (name, count) for name in ("local", "dask") for count in (3, 6)
    ]
    assert values_of(report.tables["re-run"], "cached", "evaluated") == [(7, 0)]
    assert asked == [None] * 4 + ["tls://scheduler"] * 4 + [None] * 2
    assert report.module == engine.__name__ and lines[-1] == "re-run"


@pytest.mark.slow
def test_times_and_memory_are_those_of_the_coordinator():
    """The run takes less than its process; what the parent of that process has had counts for nothing."""
    ballast = b"x" * 400_000_000
    with toy_shot(2) as shot:
        found = shot.run((EACH, SCAN), 1)
        again = shot.run((EACH, SCAN), 1)
    del ballast
    assert (found.evaluated, found.cached) == (5, 0) and (again.evaluated, again.cached) == (0, 5)
    assert 0.0 < found.run < found.process
    assert found.memory is None or 10.0 < found.memory < 300.0


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="Dask is not installed")
def test_evaluations_on_a_cluster_are_counted():
    with dask_cluster.dask_cluster(1) as scheduler, toy_shot(2) as shot:
        found = shot.run((EACH,), 1, scheduler)
    assert (found.evaluated, found.cached) == (3, 0)


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
