"""Housekeeping: what is in a store, and what may go."""

import os
import time

import pytest

from hairpipe.engine.plan import maintenance
from hairpipe.engine.plan.maintenance import clean, items, live_keys, usage
from hairpipe.engine.run import publish

pytestmark = pytest.mark.usefixtures("kept")

READER = """
from pathlib import Path
from numeral import Numeral
from tally import numeral, tally

from hairpipe.engine import File, node

@node(frames="once")
def read_list(file: File, *, how: str = "open") -> Numeral:
    "Measure a file, which somebody cleans away when it is first read."
    tally("read_list")
    path = next(iter(file.companions.values()), file.path)
    if not Path("{flag}").exists():
        Path("{flag}").touch()
        path.unlink()
    return numeral(float(len(path.read_bytes())))
"""


def test_usage_counts_every_object_once(shot):
    shot.run()
    used = usage(shot.store)
    on_disk = sum(path.stat().st_size for path in shot.store.root.glob("objects/??/*"))
    counts = {"make_seed": 1, "move_seed": 10, "add_up": 10, "write_list": 1}
    assert {name: count for name, (count, _) in used.items()} == counts
    assert sum(size for _, size in used.values()) == on_disk
    assert len(list(items(shot.store))) == 22


def test_cleaning_keeps_what_a_graph_reaches(shot):
    shot.run()
    shot.run(seed__value=9)
    shot.tally()
    swept = clean(shot.store, keep=live_keys(shot.store, [shot.load()]))
    assert swept.records == 22 and swept.objects > 15 and swept.size > 0
    shot.run()
    assert shot.tally() == {}
    assert "(unused)" not in usage(shot.store)
    shot.run(seed__value=9)
    assert shot.tally()["add_up"] == 10


def test_cleaning_keeps_what_is_behind_a_result_that_is_missing(shot):
    shot.run()
    shot.store.remove(shot.store.object_path(shot.results()["seed"][""]))
    assert clean(shot.store, keep=live_keys(shot.store, [shot.load()])).records == 0
    shot.tally()
    shot.run()
    assert shot.tally() == {"make_seed": 1}


def test_cleaning_by_age_and_size_takes_the_least_used_first(shot):
    shot.run()
    for item in items(shot.store):
        if item.record.node != "move":
            os.utime(shot.store.action_path(item.record.key), (0, time.time() - 3600))
    assert clean(shot.store, older=7200).records == 0
    total = sum(size for _, size in usage(shot.store).values())
    assert clean(shot.store, older=1800, size=total).records == 0
    assert clean(shot.store, older=1800).records == 12
    assert set(usage(shot.store)) == {"move_seed"}
    assert clean(shot.store).records == 10
    assert list(shot.store.root.glob("objects/??/*")) == []


def test_cleaning_under_a_run_costs_time_and_nothing_else(shot):
    """Everything goes when the scan is at frame 5: the run computes again what it misses, and ends as ever."""
    shot.run()
    right = shot.results()
    clean(shot.store)
    shot.tally()
    cleaned = []

    def sweep_once(event):
        if str(event.task) == "sum@5" and event.kind == "finished" and not cleaned:
            cleaned.append(clean(shot.store))

    assert shot.run(report=sweep_once).exit_code == 0
    assert cleaned[0].objects > 5
    assert (shot.folder / "out" / "list.txt").exists()
    shot.run()
    assert shot.results() == right


@pytest.mark.parametrize("parts", ["true", "false"])
def test_a_file_that_goes_while_a_node_reads_it_is_computed_again(shot, parts):
    (shot.nodes / "read_list.py").write_text(READER.replace("{flag}", str(shot.folder / "flag")))
    shot.add('[read]\ntype = "read_list"\nin.file = "list"\n')
    outcome = shot.run(list__parts=parts)
    counts = shot.tally()
    assert outcome.failures == () and (counts["write_list"], counts["read_list"], counts["add_up"]) == (2, 2, 10)


@pytest.mark.parametrize("which", [0, 1, "set", "record"])
def test_result_removed_during_publishing_is_computed_again(shot, monkeypatch, which):
    """The file, its companion, the list of both, or all of the result."""
    real, gone = publish.files_of, []

    def files_of(store, output, path):
        files = dict(real(store, output, path))
        if not gone:
            name = output.object if which in ("set", "record") else list(files.values())[which]
            gone.append(name)
            store.remove(store.object_path(name))
            if which == "record":
                clean(store)
        return files if which in (0, 1) else real(store, output, path)

    monkeypatch.setattr(publish, "files_of", files_of)
    outcome = shot.run(list__parts="true")
    assert outcome.failures == () and shot.tally()["write_list"] == 2
    assert {path.name for path in (shot.folder / "out").rglob("*.txt")} == {"list.txt", "sums.txt"}


def test_objects_of_a_starting_run_are_not_removed(shot, monkeypatch):
    """Objects are written before the record that holds them, by a run that cleaning knows nothing of.

    Ages are measured by the clock of the file system: that of this machine may be off by hours.
    """
    shot.run()
    clock = time.time
    monkeypatch.setattr(time, "time", lambda: clock() + 7 * 3600)
    results, records = shot.results(), list(items(shot.store))
    for item in records:
        shot.store.remove(shot.store.action_path(item.record.key))
    assert clean(shot.store).objects == 0
    for name in shot.store.object_names():
        os.utime(shot.store.object_path(name), (0, 0))
    shot.store.renew(results["seed"][""])
    assert clean(shot.store).objects > 10 and list(shot.store.object_names()) == [results["seed"][""]]


def test_objects_added_during_cleaning_are_kept(shot, monkeypatch):
    """Objects are listed before results, so that of an object listed the result is not missed."""
    shot.run(to=["seed"])
    there = set(shot.store.object_names())
    listing = maintenance.objects

    def objects(store):
        found = listing(store)
        shot.run(to=["move"])
        return found

    monkeypatch.setattr(maintenance, "objects", objects)
    clean(shot.store, older=3600.0)
    assert there <= set(shot.store.object_names()) and len(list(shot.store.object_names())) == 11
