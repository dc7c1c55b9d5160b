"""The benches `promises` and `needs`: tables, and where they are from. What is tuned is made up."""

import json
import re

import pytest

from hairpipe.app.tune.measured import Tolerance
from hairpipe.app.tune.study import Interrupted
from hairpipe.graphs.experiments.bench.scene_commands import PROGRAM
from hairpipe.graphs.experiments.scenes import needs, promises

HEAD = re.compile(r"commit (?:[0-9a-f]{7}\b|of version )[^;]*; machine [^;]+; command `(.+)`")


def test_promises_are_a_table_below_commit_machine_and_command(bench, monkeypatch, tmp_path):
    tried = []

    def try_promise(shot, number, scene, run, echo):
        tried.append(number)
        return promises.Promise(number, scene, None)

    monkeypatch.setattr(promises, "try_promise", try_promise)
    result = bench(f"promises --seed 2 --scenes 1-3x2 --markdown --cache {tmp_path}")
    head, _, names, _, first, *_ = result.stdout.splitlines()
    assert tried == [1, 3] and first.startswith("| 1 | ")
    found = HEAD.fullmatch(head)
    assert found and found[1] == f"{' '.join(PROGRAM)} promises --seed 2 --scenes 1,3"
    assert "in another motion" in names and "- 0 of 0 promises kept, of 2 scenes" in result.stdout
    assert "2 of 2: scene 3: " in result.stderr
    assert bench(f"promises --scenes none --cache {tmp_path}").exit_code == 2


def test_needs_are_a_row_for_every_scene_and_tolerance(bench, monkeypatch, tmp_path):
    given = []

    def needs_of(shots, hair, tolerances, pace, echo):
        given.append(([*shots], hair, tolerances))
        return [needs.Need(name, tolerance, None) for name in shots for tolerance in tolerances]

    monkeypatch.setattr(needs, "needs_of", needs_of)
    result = bench(f"needs tune/short_slow --tolerance 2mm --tolerance 3% --markdown --cache {tmp_path}")
    assert given == [(["short_slow"], "hair", [Tolerance(2e-3, "m"), Tolerance(3.0, "%")])]
    head, *lines = result.stdout.splitlines()
    found = HEAD.fullmatch(head)
    assert (
        found
        and found[1]
        == "python -m hairpipe.graphs.experiments.bench needs tune/short_slow --tolerance 2mm --tolerance 3%"
    )
    assert [line.split(" | ")[:2] for line in lines[3:]] == [["| short_slow", "2 mm"], ["| the same", "3 %"]]
    document = json.loads(bench(f"needs tune/short_slow --json --cache {tmp_path}").stdout)
    assert [need["within"]["value"] for need in document] == [1.0, 3.0, 10.0]


def test_interrupted_measurements_are_kept(bench, monkeypatch, tmp_path):
    def needs_of(*_):
        raise Interrupted

    monkeypatch.setattr(needs, "needs_of", needs_of)
    result = bench(f"needs tune/short_slow --cache {tmp_path}")
    assert result.exit_code == 130 and "the same command resumes" in result.stderr


@pytest.mark.parametrize("tolerance", ["3", "0%"])
def test_a_tolerance_has_a_unit(bench, tolerance, tmp_path):
    assert bench(f"needs tune/short_slow --tolerance {tolerance} --cache {tmp_path}").exit_code == 2
