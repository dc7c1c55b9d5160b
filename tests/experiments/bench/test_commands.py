"""The benches of parts: arguments, tables and exit codes."""

import json
import os

import pytest

from hairpipe.engine.worker.machine_code import TABLE
from hairpipe.graphs.experiments.bench import contact, core, faults
from hairpipe.graphs.experiments.bench.machine import Machine
from hairpipe.graphs.experiments.bench.report import Report

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


def test_an_unknown_benchmark_is_refused(bench):
    assert bench("everything").exit_code == 2


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


@pytest.mark.parametrize(("found", "code"), [([], 0), (["kill 3: other results"], 1)])
def test_faults_are_a_table_and_an_exit_code(bench, monkeypatch, found, code):
    count = faults.Count("kill", "coordinator")
    for fault in ["", *found]:
        count.add(fault)
    tables = {"trials": [count.case], "faults": [{"fault": fault} for fault in found]}
    monkeypatch.setattr(faults, "try_faults", lambda echo, check, seed: Report("faults", MACHINE, tables))
    result = bench("faults --seed 7")
    assert result.exit_code == code and all(fault in result.stdout for fault in found)
    assert json.loads(bench("faults --json").stdout)["tables"]["trials"][0]["faults"] == code
