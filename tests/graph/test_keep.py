"""Housekeeping: what is in a store, and what may go."""

import os
import time

from hairpipe.graph.keep import clean, items, reached, usage


def test_usage_counts_every_object_once(shot):
    shot.run()
    used = usage(shot.store)
    on_disk = sum(path.stat().st_size for path in shot.store.root.glob("objects/??/*"))
    assert {name: count for name, (count, _) in used.items()} == {
        "make_seed": 1,
        "move_seed": 10,
        "add_up": 10,
        "write_list": 1,
    }
    assert sum(size for _, size in used.values()) == on_disk
    assert len(list(items(shot.store))) == 22


def test_cleaning_keeps_what_a_graph_reaches(shot):
    shot.run()
    shot.run(seed__value=9)
    shot.tally()
    swept = clean(shot.store, keep=reached(shot.store, [shot.load()]))
    assert swept.records == 22 and swept.objects > 15 and swept.size > 0
    shot.run()
    assert shot.tally() == {}
    assert "(unused)" not in usage(shot.store)
    shot.run(seed__value=9)
    assert shot.tally()["add_up"] == 10


def test_cleaning_keeps_what_is_behind_a_result_that_is_missing(shot):
    shot.run()
    shot.store.remove(shot.store.object_path(shot.results()["seed"][""]))
    assert clean(shot.store, keep=reached(shot.store, [shot.load()])).records == 0
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
