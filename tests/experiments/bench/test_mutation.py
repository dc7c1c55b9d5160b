"""The bench `mutate`: what it changes, that tests see the change, and its scores."""

import ast
import json
import os
import random
import sys
from contextlib import nullcontext
from types import SimpleNamespace

import pytest
from scipy.stats import binomtest

from hairpipe.graphs.experiments.bench.mutation import mutation_trials as trials
from hairpipe.graphs.experiments.bench.mutation import tester
from hairpipe.graphs.experiments.bench.mutation.mutation_trials import Trial
from hairpipe.graphs.experiments.bench.mutation.suites import KEY, PACKAGE, SUITES, TESTS

SOURCE = '''"""A room."""
LEAST = 3


def keep(values: list[int | None], most: int | None = 2) -> "list[int] | None":
    """Keep values."""
    if len(values) < most:
        raise ValueError(f"{len(values) + 1} values are too few")
    values.sort()
    return values[:most]
'''


def test_every_file_of_the_rooms_has_tests():
    home = trials.HOME / PACKAGE
    files = {
        path.relative_to(home).as_posix()
        for room in ("engine/store", "engine/run", "laws")
        for path in (home / room).glob("*.py")
        if path.stem not in ("__init__", "settings")
    }
    assert files | set(KEY) == set(SUITES)
    named = {
        trials.HOME / os.path.normpath(f"{TESTS}/{name}").partition("::")[0]
        for names in SUITES.values()
        for name in names
    }
    assert all(path.exists() for path in named)


@pytest.mark.parametrize(("count", "survived"), [(1, 0), (60, 0), (60, 7), (60, 60)])
def test_interval_is_that_of_wilson(count, survived):
    tried = [Trial("a.py", 1, "", "survived" if number < survived else "killed") for number in range(count)]
    score = trials.score_of(tried)
    assert score["score [%]"] == pytest.approx(100.0 * (count - survived) / count)
    exact = binomtest(count - survived, count).proportion_ci(method="wilson")
    assert score["from [%]"] == pytest.approx(100.0 * exact.low, abs=0.01)
    assert score["to [%]"] == pytest.approx(100.0 * exact.high, abs=0.01)


def test_places_are_what_the_code_does_and_each_is_changed_once():
    pytest.importorskip("cosmic_ray", reason="Cosmic Ray is absent: it is in the extra `mutation`")
    from hairpipe.graphs.experiments.bench.mutation.places import changed_source, draw_places

    places = draw_places(SOURCE, random.Random(5))
    assert places == draw_places(SOURCE, random.Random(5))
    changed = [changed_source(SOURCE, mutants) for mutants in places]
    lines = [trials.change_of(SOURCE, text)[0] for text in changed]
    assert len(set(changed)) == len(changed) and all(ast.parse(text) for text in changed)
    assert sorted(lines) == [2, 5, 7, 7, 8, 9, 10], "a number, a default, a condition twice, two statements, a result"
    assert not any("values are too few" not in text for text in changed if "raise" in text)


def test_outcomes_are_kept_once_and_a_room_without_mutations_has_no_score(tmp_path, monkeypatch):
    places = SimpleNamespace(changed_source=lambda source, line: f"{source}# {line}\n")
    monkeypatch.setitem(sys.modules, "hairpipe.graphs.experiments.bench.mutation.places", places)  # needs Cosmic Ray
    monkeypatch.setattr(trials, "find_spec", lambda name: name)
    monkeypatch.setattr(trials, "testing", nullcontext)
    monkeypatch.setattr(trials, "limit_of", lambda tester, file: 1.0)
    monkeypatch.setattr(trials, "outcome_of", lambda tester, file, source, changed, limit: outcomes.pop(0))
    drawn = {"run": [("engine/run/publish.py", 1), ("engine/run/publish.py", 2)], "key": []}
    monkeypatch.setattr(trials, "drawn", lambda room, most, seed: (drawn[room], len(drawn[room])))
    known, outcomes = tmp_path / "known", ["killed", "survived", "killed"]
    for _ in range(2):
        (score,) = trials.try_mutations(print, ["run", "key"], 2, 0, known).tables["scores"]
    assert outcomes == [] and (score["first [%]"], score["score [%]"]) == (50.0, 100.0)
    assert [json.loads(line)[3] for line in known.read_text().splitlines()] == ["killed", "survived", "killed"]


@pytest.mark.parametrize(
    ("text", "limit", "code"),
    [
        ("assert True", 60.0, 0),
        ("assert False", 60.0, 1),
        ("raise SystemExit(0)", 60.0, 1),
        ("while True: 1", 0.5, None),
    ],
)
def test_a_forked_process_runs_tests_and_is_stopped(tmp_path, text, limit, code):
    (tmp_path / "test_it.py").write_text(f"def test_it():\n    {text}\n")
    words = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-c", os.devnull, str(tmp_path / "test_it.py")]
    assert tester.run_tests(words, limit) == code
