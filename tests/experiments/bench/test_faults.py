"""The campaigns of the bench `faults`, in short: that they find what is wrong, and that nothing is."""

import random

import pytest

from hairpipe.child import withheld
from hairpipe.engine.node.import_paths import leave
from hairpipe.engine.run import publish
from hairpipe.formats.hdf5 import digest_file
from hairpipe.graphs.experiments.bench import faults
from hairpipe.graphs.experiments.bench.faults import Trials, held, toy_shot, try_damages, try_faults, undisturbed

SHORT = Trials(kills=1, damages=2, cleanings=1, modules=())


@pytest.fixture(autouse=True)
def nothing_stays():
    """Take the toys' folders off Python's path: other tests have toys of the same names."""
    yield
    for folder in list(withheld):
        leave(folder)


@pytest.mark.slow
def test_everything_holds_in_short():
    reported = []
    report = try_faults(reported.append, digest_file, 3, SHORT)
    assert held(report), [
        *report.tables.get("faults", ()),
        *filter(lambda case: case["done twice"], report.tables["trials"]),
    ]
    trials = report.tables["trials"]
    assert {case["campaign"] for case in trials} == {"kill", "damage", "cleaning"} and len(reported) == 5
    assert sum(case["trials"] for case in trials) == 4 == sum(case["same bytes"] + case["refused"] for case in trials)


@pytest.mark.slow
def test_injected_faults_are_found(tmp_path, monkeypatch):
    """A listing that is believed is published under a wrong name."""
    monkeypatch.setattr(faults, "DAMAGES", (faults.plant_json,))
    with toy_shot(tmp_path) as shot:
        truth = undisturbed(shot)

        def believing(store, output, path):
            return {path.parent / "elsewhere.txt": output.parts[0][0]}

        monkeypatch.setattr(publish, "files_of", believing)
        (count,) = try_damages(shot, truth, random.Random(1), 1, digest_file)
    assert count.case["faults"] and "published other bytes" in count.faults[0]


@pytest.mark.parametrize("harm", faults.DAMAGES)
def test_damages_are_of_the_seed(tmp_path, harm):
    seen = []
    for name in ("a", "b"):
        path = tmp_path / name
        path.write_bytes(bytes(range(100)))
        harm(path, random.Random(5))
        seen.append(
            path.read_bytes() if path.is_file() else [p.name for p in path.iterdir()] if path.exists() else None
        )
    assert seen[0] == seen[1] != bytes(range(100))
