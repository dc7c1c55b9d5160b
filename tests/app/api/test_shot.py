"""The Python interface: load, plan, run, get."""

import subprocess
import sys

import pytest

import hairpipe
from hairpipe.errors import BadInput


def test_ten_lines_of_a_notebook(shot):
    loaded = hairpipe.load("shot.toml", {"seed.value": 4}, cache="cache")
    assert repr(loaded) == "<Shot shot.toml: 5 nodes, frames 1-6 at 24 fps>"
    assert list(loaded.nodes)[:3] == ["seed", "move", "sum"] and loaded.frames == range(1, 7)
    assert repr(loaded.plan("1-2", to="sum")).endswith(
        "1 result to compute, up to 4 more, depending on these results, 0 cached"
    )
    report = loaded.run("1-2", to="sum", jobs=1)
    assert report.ok and "5 results computed, 0 cached" in repr(report)
    assert loaded.get("sum.number@2").value == loaded.get("sum@2").value == report.get("sum@2").value
    assert [value.value for value in loaded.get("sum", frames="1-2").values()] == [5.0, 0.9 * 5 + 6]
    assert loaded.explain("sum@2").entry.status == "cached"
    assert loaded.changed({"seed.value": 5}).explain("seed").reasons == ("setting value 4.0 -> 5.0",)


def test_repr_of_a_shot_is_short(computed):
    loaded = hairpipe.load(computed)
    assert repr(loaded.nodes["sum"]) == "<Node sum: add_up, number from move>"
    assert repr(loaded.nodes["sum"].type) == "<NodeType add_up(number: Numeral) -> number: Numeral, state: Sum>"
    assert repr(loaded.graph).startswith("<Graph ") and repr(loaded.graph).endswith("at 24 fps>")
    assert repr(loaded.results(to="seed")).startswith("{'seed': <Record seed: make_seed, ")
    text = repr(loaded.explain("sum@4"))
    assert text.startswith("sum@4: cached\n\ntype") and "Explanation(" not in text


def test_settings_of_a_run_are_those_of_its_report(shot):
    loaded = hairpipe.load(shot)
    report = loaded.run(to=["seed"], set={"seed.value": 7}, jobs=1)
    assert report.get("seed").value == 7.0
    with pytest.raises(BadInput, match="'seed' has not been computed"):
        loaded.get("seed")


def test_results_are_listed_with_what_they_took(computed):
    results = hairpipe.load(computed).results(to="sum")
    assert list(results) == ["seed", *(f"{node}@{frame}" for node in ("move", "sum") for frame in range(1, 7))]
    assert results["sum@6"].seconds > 0.0 and results["sum@6"].node == "sum"


def test_events_can_be_printed(shot, capsys):
    hairpipe.load(shot).run(to="seed", jobs=1, progress=print)
    first, second, third = capsys.readouterr().out.splitlines()
    assert (first, second) == ("begun: 1 results", "seed: started") and third.startswith("seed: finished in ")


def test_a_failure_is_reported_not_raised(failing):
    report = hairpipe.load(failing).run(jobs=1)
    assert not report.ok and [str(failure.task) for failure in report.failures] == ["bad@3"]
    assert repr(report).endswith("failed: bad@3: ZeroDivisionError: no strands left")


def test_importing_it_loads_nothing_else():
    code = "import sys, hairpipe; dir(hairpipe); print([name for name in sys.modules if name.startswith('hairpipe.')])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"
