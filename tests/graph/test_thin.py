"""States of a scan: the last two and every n-th are there while it runs, every n-th and the last afterwards."""

from collections import Counter

from hairpipe.graph.store import Store


def kept(shot) -> list[int]:
    results = shot.results()
    return [frame for frame in range(1, 11) if shot.store.has(results[f"sum@{frame}"]["state"])]


def test_every_nth_state_and_the_last_are_kept(shot):
    shot.run()
    assert kept(shot) == [4, 8, 10]
    shot.tally()
    shot.run()
    assert shot.tally() == Counter(), "a thinned state is no miss while nobody needs it"


def test_states_that_somebody_looks_at_stay(shot):
    shot.path.write_text(shot.path.read_text().replace('in.numbers = "sum"', 'in.numbers = "move"'))
    source = (shot.nodes / "soften.py").read_text().replace("soften", "show_sum")
    source = source.replace("number: Pair[Numeral], other: Numeral | None = None", "sum: Sum")
    source = (
        source.replace("import Numeral", "import Numeral, Sum").split("    return")[0]
        + "    return numeral(sum.total)\n"
    )
    (shot.nodes / "show_sum.py").write_text(source)
    shot.path.write_text(shot.path.read_text() + '[show]\ntype = "show_sum"\nin.sum = "sum"\n')
    assert shot.run().exit_code == 0
    assert kept(shot) == list(range(1, 11))


def test_longer_range_goes_on_from_the_last_state(shot):
    shot.run(frames=range(1, 7))
    shot.tally()
    shot.run()
    assert shot.tally()["add_up"] == 4


def test_state_that_is_needed_is_recomputed_from_the_nearest(shot):
    shot.run()
    before = shot.results()
    shot.tally()
    for frame in (4, 8, 10):
        shot.store.remove(shot.store.object_path(before[f"sum@{frame}"]["state"]))
    shot.path.write_text(shot.path.read_text().replace("[1, 10]", "[1, 11]"))
    shot.run()
    assert shot.tally() == Counter(move_seed=1, add_up=11, write_list=1)
    after = shot.results()
    assert {name: after[name] for name in before if name != "list"} == {n: before[n] for n in before if n != "list"}


def test_states_go_while_the_scan_goes_on(shot, tmp_path):
    other = Store(tmp_path / "other")
    shot.run(store=other)
    names = shot.results(other)
    there = []

    def look(event):
        if event.kind == "finished" and event.task.node == "sum":
            there.append([frame for frame in range(1, 11) if shot.store.has(names[f"sum@{frame}"]["state"])])

    shot.run(report=look)
    assert there[:4] == [[1], [1, 2], [1, 2, 3], [2, 3, 4]], "a state goes once the result after the next is noted"
    assert there[7:] == [[4, 6, 7, 8], [4, 7, 8, 9], [4, 8, 9, 10]]
    assert kept(shot) == [4, 8, 10]
