"""Kernels that the first use of a graph compiles, by function."""

import re
from subprocess import CompletedProcess

import pytest

from hairpipe.engine.worker.machine_code import FOLDER_DIGITS
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.engine import first_use
from hairpipe.graphs.experiments.bench.engine.first_use import kernels_in


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
