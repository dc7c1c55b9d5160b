"""Cost of the engine: what is counted and compared; no time is asserted."""

import importlib.util
import re
import tomllib
from contextlib import nullcontext
from subprocess import CompletedProcess

import pytest

from hairpipe.engine.store.store import Output, Record
from hairpipe.engine.worker.machine_code import FOLDER_DIGITS
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.engine import dask_cluster, engine, first_frame, first_use
from hairpipe.graphs.experiments.bench.engine.engine import Sizes, difference, measure_engine
from hairpipe.graphs.experiments.bench.engine.engine_shot import EACH, SCAN, ToyRun, ToyShot, toy_shot
from hairpipe.graphs.experiments.bench.engine.first_use import kernels_in
from hairpipe.graphs.experiments.bench.engine.traffic import measure_traffic, traffic_of

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


def test_a_phase_is_counted_without_the_phases_within_it(monkeypatch):
    now = iter([0.0, 1.0, 3.0, 7.0])
    monkeypatch.setattr("time.process_time", lambda: next(now))
    clock = first_frame.Clock()
    with clock.phase("outer"):
        clock.counted("inner", lambda: None)()
    assert clock.seconds == {"outer": 5.0, "inner": 2.0}


@pytest.mark.slow
def test_a_new_process_is_measured(shot):
    cases = first_frame.measure_first_frame(shot.path, {}, "sum").tables["phases"]
    phases = {case["phase"]: case["processor [s]"] for case in cases}
    assert phases[first_frame.PYTHON] > 0 and phases[first_frame.NUMBA] > 0
    assert {first_frame.IMPORTS, first_frame.SECOND} <= phases.keys()


def test_kernels_are_named_by_module_and_function(tmp_path):
    folder = tmp_path / f"hairpipe.solve.conjugate_gradients-{'0' * FOLDER_DIGITS}"
    folder.mkdir()
    for name in (
        "pcg._turn-110.py311.aa.nbc",
        "pcg._turn-110.py311.bb.nbc",
        "pcg.run.locals.f-7.py311.cc.nbc",
        "x.tmp",
    ):
        (folder / name).write_text("")
    turn, inner = "hairpipe.solve.conjugate_gradients._turn", "hairpipe.solve.conjugate_gradients.run.locals.f"
    assert list(kernels_in(tmp_path)) == [turn, turn, inner]


def test_processor_seconds_are_those_of_both_runs(tmp_path, monkeypatch):
    """In temporary folders: the second run has the kernels of the first, and none of its results."""
    path = tmp_path / "shot.toml"
    path.write_text('schema = 1\nframes = [3, 9]\nfps = 24\n[hair]\ntype = "make_bust"\n')
    begun, caches = [], []

    def run(command, env, **_):
        caches.append(command[-2].partition("--cache', '")[2].partition("'")[0])
        begun.append(env["NUMBA_CACHE_DIR"])
        assert "'--frames', '3-4'" in command[-2]
        return CompletedProcess(command, 0)

    monkeypatch.setattr(first_use.subprocess, "run", run)
    seconds = iter([1.0, 11.0, 11.0, 13.0])
    monkeypatch.setattr(first_use, "children_seconds", lambda: next(seconds))
    report = first_use.measure_first_use(path, {})
    [case] = report.tables["first use"]
    assert (case["without kernels [processor s]"], case["with kernels [processor s]"]) == (10.0, 2.0)
    assert [*report.tables] == ["first use"] and case["kernels"] == case["functions"] == 0
    assert len(set(begun)) == 1 and len(set(caches)) == 2 and all(caches)


def test_a_graph_that_does_not_compute_is_named(tmp_path):
    path = tmp_path / "shot.toml"
    path.write_text('schema = 1\nframes = [1, 2]\nfps = 24\n[hair]\ntype = "load_body"\nfile = "absent.obj"\n')
    with pytest.raises(BadInput, match=re.escape(str(path))):
        first_use.measure_first_use(path, {})


def test_frames_write_their_results_and_the_state_at_the_checkpoint(shot):
    """Four frames, of which the last is a checkpoint; sizes are those of the files of a run that keeps all states."""
    shot.path.write_text(shot.path.read_text().replace("checkpoint = 4", "checkpoint = 1").replace("[1, 10]", "[1, 4]"))
    shot.run()
    size = shot.store.size
    numbers, states = ([size(shot.results()[f"sum@{f}"][name]) for f in range(1, 5)] for name in ("number", "state"))
    inputs = [size(shot.results()[f"move@{frame}"][""]) for frame in range(2, 5)]
    shot.path.write_text(shot.path.read_text().replace("checkpoint = 1", "checkpoint = 4"))
    lines = []
    (case,) = measure_traffic(lines.append, {"toy": shot.path}, {}, "sum").tables["traffic"]
    assert (lines, case["graph"], case["frames"]) == (["toy"], "toy", 4)
    assert case["written with every state [MB]"] == pytest.approx(1e-6 * sum(numbers + states) / 4)
    assert case["written [MB]"] == pytest.approx(1e-6 * (sum(numbers) + states[3]) / 4)
    assert case["read [MB]"] == pytest.approx(1e-6 * sum(inputs) / 3)


def test_a_link_carries_as_many_as_its_bytes_a_second_divided_by_theirs():
    """A frame of 4 s on one of two cores writes 5 MB and reads 2.5 MB that are new: 2.5 MB/s, of 125 and 1,250."""
    names = [f"{number:040x}.h5" for number in range(4)]
    outputs = {"strands": Output(names[0], 5_000_000), "state": Output(names[3], 40_000_000)}
    inputs = [{"body": [names[1], names[2]], "groom": names[3], "previous": names[0]}]
    inputs.append({"body": [names[2], names[0]], "groom": names[3], "surface": None, "previous": names[1]})
    records = [Record("", "hair", 1, {"inputs": found}, outputs, "state", 9.0, (), 0.0, 4.0) for found in inputs]
    case = traffic_of(records, set(names[:3]), dict.fromkeys(names, 2_500_000), cores=2)
    assert case["written [MB]"] == 5.0 and case["read [MB]"] == 2.5 and case["written with every state [MB]"] == 45.0
    assert (case["simulations on 1 Gbit/s"], case["simulations on 10 Gbit/s"]) == (50.0, 500.0)
