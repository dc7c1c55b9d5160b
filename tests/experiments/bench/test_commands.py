"""Commands of benches: arguments, tables and exit codes."""

import json
import os
import re

import pytest

from hairpipe.app.tune.measured import Tolerance
from hairpipe.app.tune.study import Interrupted
from hairpipe.engine.worker.machine_code import TABLE
from hairpipe.graphs.experiments.bench import contact, core, faults
from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.machines import parity, trials
from hairpipe.graphs.experiments.bench.report import Report
from hairpipe.graphs.experiments.bench.scene_commands import PROGRAM
from hairpipe.graphs.experiments.scenes import needs, promises

MACHINE = Machine("A Processor", 2, {"numba": "1.2"})


@pytest.fixture(autouse=True)
def table(monkeypatch):
    monkeypatch.setenv(TABLE, os.environ[TABLE])  # the command sets it for its own process


def test_progress_is_not_a_result(monkeypatch, bench):
    def measure(echo):
        echo("17 strands")
        return Report("core", MACHINE, {"kernels": [{"kernel": "solve", "median [ns a particle]": 44.04}]})

    monkeypatch.setattr(core, "measure_core", measure)
    result = bench("core --json")
    assert result.stderr == "17 strands\n"
    assert json.loads(result.stdout)["tables"] == {"kernels": [{"kernel": "solve", "median [ns a particle]": 44.04}]}


def test_a_table_that_is_wider_than_the_screen_is_whole(monkeypatch, bench):
    monkeypatch.setenv("COLUMNS", "40")
    shares = {f"{name} [s]": 10.25 for name in ("strands", "search", "stiction", "coupling", "collisions", "body")}
    case = {"segments": 1_000_000, "between": "locks", "threads": 2, "frame [s]": 117.5, **shares}
    given = []
    monkeypatch.setattr(
        contact,
        "measure_contact",
        lambda echo, *words: given.append(words) or Report("contact", MACHINE, {"x": [case]}),
    )
    lines = [line.split() for line in bench("contact --between locks --moving 8").stdout.splitlines()]
    assert given == [(contact.SEGMENTS, ("locks",), 8)]
    assert ["1,000,000", "locks", "2", "118", *["10.2"] * 6] in lines


@pytest.mark.parametrize(("violation", "code"), [("", 0), ("other bytes", 1)])
def test_campaigns_are_a_table_and_an_exit_code(bench, monkeypatch, violation, code):
    count, case = faults.Count("kill", "coordinator"), {"fault": "child killed", "violation": violation}
    count.add(violation)
    tables = {"trials": [count.case], "faults": [case] if violation else [], "ways": [case]}
    chosen = []

    def try_machines(echo, check, faults):
        chosen.append([fault.what for fault in faults])
        return Report("x", MACHINE, {"faults": [case]})

    monkeypatch.setattr(faults, "try_faults", lambda echo, check, seed: Report("faults", MACHINE, tables))
    monkeypatch.setattr(trials, "try_machines", try_machines)
    monkeypatch.setattr(parity, "compare_ways", lambda echo, check: Report("x", MACHINE, tables))
    for command in ("faults --seed 7", "machines --only stale", "parity --json"):
        result = bench(command)
        assert result.exit_code == code and violation in result.stdout
    assert chosen == [["two runs, one with stale listings"]]
    assert json.loads(bench("faults --json").stdout)["tables"]["trials"][0]["faults"] == code


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
