"""The benches of parts: their reports as tables and as JSON."""

import json
import os

import pytest

from hairpipe.bench.machine import Machine
from hairpipe.graph.run.kernel_cache import TABLE
from hairpipe.graphs.experiments.bench import contact, core, particles
from hairpipe.graphs.experiments.bench.arithmetic.assembly import Arithmetic
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work
from hairpipe.graphs.experiments.bench.repeat import Spread
from hairpipe.graphs.experiments.bench.roofs import Roofs

REPORT = core.Report(
    Machine("A Processor", 2, {"numba": "1.2"}),
    core.FULL,
    Roofs({"float64": Spread(58e9, 57e9, 59e9, 9)}, {1: Spread(20e9, 19e9, 21e9, 9)}),
    {"network": {"float64": Work(1200.4, 250.0)}, "rod": {"float64": Work(2150.0, 450.0)}},
    {"network": {"float64": Arithmetic(990, 3, 4, 5)}, "rod": {"float64": Arithmetic(1990, 6, 7, 8)}},
    [
        core.Case("solve", "network", "cache", "float64", 1, Spread(44.0, 43.0, 46.0, 9), 20.7, 40.0, 90.0),
        core.Case("solve", "rod", "cache", "float64", 1, Spread(63.0, 62.0, 64.0, 9), 37.0, None, 67.5),
    ],
    23.0,
)


@pytest.fixture
def measured(monkeypatch):
    monkeypatch.setenv(TABLE, os.environ[TABLE])  # the command sets it for its own process

    def measure(say):
        say("17 strands")
        return REPORT

    monkeypatch.setattr(core, "measure_core", measure)


def test_tables_say_what_was_measured(measured, bench):
    text = bench("core").stdout
    rows = [line.split() for line in text.splitlines()]
    assert ["solve", "network", "cache", "float64", "1", "44.0", "43.0-46.0", "20.7", "40.0", "1.10"] in rows
    assert ["solve", "rod", "cache", "float64", "1", "63.0", "62.0-64.0", "37.0"] in rows
    assert ["solve", "cache", "float64", "1", "90.0", "(1.00)", "67.5", "(0.75)"] in rows
    assert ["network", "float64", "1200", "250", "990", "3", "4", "5"] in rows
    for part in ("A Processor, 2 cores", "numba 1.2", "58.0 (57.0-59.0) GFLOP/s", "20.0 (19.0-21.0) GB/s", "23.0 s"):
        assert part in text


def test_a_document_has_all_of_it(measured, bench):
    result = bench("core --json")
    assert result.stderr == "17 strands\n", "what is being done is no result"
    document = json.loads(result.stdout)
    assert document["cases"][0]["time"] == {"median": 44.0, "low": 43.0, "high": 46.0, "runs": 9}
    assert document["roofs"]["triad"]["1"]["median"] == 20e9
    assert document["machine"]["versions"] == {"numba": "1.2"}
    assert document["code"]["network"]["float64"]["scalar"] == 5 and document["compiled"] == 23.0


def test_an_unknown_benchmark_is_refused(bench):
    assert bench("everything").exit_code == 2


def test_a_table_that_is_wider_than_the_screen_is_whole(monkeypatch, bench):
    monkeypatch.setenv(TABLE, os.environ[TABLE])
    monkeypatch.setenv("COLUMNS", "40")
    shares = {name: 10.25 for name in ("strands", "search", "stiction", "coupling", "collisions", "body", "other")}
    case = contact.Case(1_000_000, "locks", 2_040_000, 0.25, 2, 117.5, shares, 987_654)
    report = contact.Report(REPORT.machine, contact.FULL, 10, REPORT.roofs, [case])
    given = []
    monkeypatch.setattr(contact, "measure_contact", lambda say, sizes: given.append(sizes) or report)
    lines = [line.split() for line in bench("contact --between locks --moving 8").stdout.splitlines()]
    assert given == [contact.FULL._replace(between=("locks",), moving=8)]
    assert ["1,000,000", "locks", "2,040,000", "25%", "987,654", "2", "117.50", *["10.25"] * 7] in lines
    assert ["triad,", "1", "thread", "20.0", "(19.0-21.0)", "GB/s"] in lines


def test_particles_are_counted_in_link_passes(monkeypatch, bench):
    monkeypatch.setenv(TABLE, os.environ[TABLE])
    case = particles.Case(2_003, 13_280, 28_000.0, 1, 14.5, 3e-3, 2.003e-3, {"search": 5e-4, "solve": 1e-3})
    report = particles.Report(REPORT.machine, particles.FULL, 4e-9, [case])
    monkeypatch.setattr(particles, "measure_particles", lambda say: report)
    lines = [line.split() for line in bench("particles").stdout.splitlines()]
    assert ["2,003", "13,280", "28,000", "1", "14.5", "3.00", "2.00", "1.00", "250"] in lines
    assert ["2,003", "1", "0.50", "1.00"] in lines


@pytest.mark.parametrize(("found", "code"), [([], 0), (["kill 3: other results"], 1)])
def test_faults_are_a_table_and_an_exit_code(bench, monkeypatch, found, code):
    from hairpipe.graphs.experiments.bench import faults

    row = faults.Row("kill", "coordinator", 60, 60 - len(found), 0, 0, found)
    monkeypatch.setattr(faults, "try_faults", lambda say, check, seed: faults.Report(seed, 90.0, [row]))
    result = bench("faults --seed 7")
    assert result.exit_code == code and "seed 7" in result.stdout and all(fault in result.stdout for fault in found)
    document = json.loads(bench("faults --json").stdout)
    assert document["held"] == (code == 0) and document["rows"][0]["faults"] == found
