"""Reports of benches as results."""

import os
import sys

from hairpipe.engine.worker.machine_code import TABLE
from hairpipe.graphs.experiments.bench import paper
from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.report import Report
from hairpipe.graphs.experiments.figures.bench_recording import BenchRecording
from hairpipe.graphs.experiments.figures.file import read_results
from hairpipe.graphs.experiments.figures.recipe import CURRENT, state_of

from .conftest import edit, git

MACHINE = Machine("A Processor", 2, {"numba": "1.2"})
CASES = [{"kernel": "solve", "median [ns]": 2.5, "floor": None}, {"kernel": "step", "ratio": 1.5}]


def test_the_table_of_the_paper_is_recorded(repository, hairpipe, monkeypatch):
    def measure(echo, scenes, store, overrides, moving, threads):
        return Report(paper.__name__, MACHINE, {"parts": [{"scene": "long_curly", "search [s]": 2.5}]})

    monkeypatch.setenv(TABLE, os.environ[TABLE])
    monkeypatch.setattr(paper, "measure_paper", measure)
    words = "bench paper long_curly --moving 7 --cache elsewhere --record graphs"
    monkeypatch.setattr(sys, "argv", ["hairpipe", *words.split()])
    assert hairpipe(words).exit_code == 0
    results = read_results(repository / "graphs/results/paper.json")
    assert results.command == "hairpipe bench paper long_curly --moving 7 --record graphs"
    assert results.tables["parts"].rows == [["long_curly", 2.5]]
    assert [name.rpartition("/")[2] for name in results.nodes] == ["long_curly.toml"]
    assert state_of(repository / "graphs/results/paper.json").word == CURRENT


def test_a_record_of_a_bench_has_the_name_that_is_given(repository, hairpipe, monkeypatch):
    monkeypatch.setenv(TABLE, os.environ[TABLE])
    monkeypatch.setattr(paper, "measure_paper", lambda *words: Report(paper.__name__, MACHINE, {"frames": CASES}))
    monkeypatch.setattr(sys, "argv", ["hairpipe", "bench", "paper"])
    assert hairpipe("bench paper long_curly --record graphs/short").exit_code == 0
    assert read_results(repository / "graphs/results/short.json").tables["frames"].rows[1][0] == "step"


def test_cases_become_rows_and_the_bandwidth_is_kept(repository):
    recording = BenchRecording(repository / "graphs", "toy")
    graph = repository / "graphs/circle.toml"
    recording.write(Report(paper.__name__, MACHINE, {"cases": CASES}, 16.04), "hairpipe bench toy", [graph])
    results = read_results(recording.path)
    assert results.tables["cases"].columns == ["kernel", "median [ns]", "floor", "ratio"]
    assert results.tables["cases"].rows == [["solve", 2.5, None, None], ["step", None, None, 1.5]]
    assert results.machine.bandwidth == 16.0 and results.commit == git(repository, "rev-parse", "HEAD")
    assert state_of(recording.path).word == CURRENT
    edit(graph, "12", "24")
    assert state_of(recording.path).changed == ("[circle.toml]",)
