"""Reports of benches as results."""

import os
import sys

import pytest

from hairpipe.bench import paper
from hairpipe.bench.machine import Machine
from hairpipe.errors import BadInput
from hairpipe.graph.run.kernel_cache import TABLE
from hairpipe.results.bench_recording import BenchRecording
from hairpipe.results.file import read_results
from hairpipe.results.state import CURRENT, state_of

from .conftest import edit, git

MACHINE = Machine("A Processor", 2, {"numba": "1.2"})
CASES = [{"kernel": "solve", "time": {"median": 2.5, "runs": 5}, "floor": None}, {"kernel": "step", "ratio": 1.5}]
ROOFS = {"triad": {"1": {"median": 10e9}, "2": {"median": 16.04e9}}}


def test_the_table_of_the_paper_is_recorded(repository, hairpipe, monkeypatch):
    def measure(say, scenes, cache, overrides, moving):
        return paper.Report(MACHINE, [paper.Row("long_curly", 99, 1234, 0.25, 4.25, {"search": 2.5}, 10**9, None)])

    monkeypatch.setenv(TABLE, os.environ[TABLE])
    monkeypatch.setattr(paper, "measure_paper", measure)
    words = "bench paper long_curly --moving 7 --cache elsewhere --record graphs"
    monkeypatch.setattr(sys, "argv", ["hairpipe", *words.split()])
    assert hairpipe(words).exit_code == 0
    results = read_results(repository / "graphs/results/paper.json")
    assert results.command == "hairpipe bench paper long_curly --moving 7 --record graphs"
    table = results.tables["rows"]
    assert dict(zip(table.columns, table.rows[0], strict=True))["shares.search"] == 2.5
    assert [name.rpartition("/")[2] for name in results.nodes] == ["long_curly.toml"]
    assert state_of(repository / "graphs/results/paper.json").word == CURRENT


def test_cases_become_rows_and_the_bandwidth_is_kept(repository):
    recording = BenchRecording(repository / "graphs", "toy")
    graph = repository / "graphs/circle.toml"
    recording.write(MACHINE, {"cases": CASES, "roofs": ROOFS}, "hairpipe bench toy", [graph])
    results = read_results(recording.path)
    assert results.tables["cases"].columns == ["kernel", "time.median", "time.runs", "floor", "ratio"]
    assert results.tables["cases"].rows == [["solve", 2.5, 5, None, None], ["step", None, None, None, 1.5]]
    assert results.machine.bandwidth == 16.0 and results.commit == git(repository, "rev-parse", "HEAD")
    assert state_of(recording.path).word == CURRENT
    edit(graph, "12", "24")
    assert state_of(recording.path).changed == ("[circle.toml]",)


def test_a_report_without_cases_is_refused(repository):
    with pytest.raises(BadInput, match="no list of cases"):
        BenchRecording(repository, "toy").write(MACHINE, {"seconds": 1.0}, "hairpipe bench toy", [])
