"""States of a scan: every n-th and the last two in between are there while it runs, every n-th and the last later."""

from collections import Counter
from types import SimpleNamespace

import pytest

from hairpipe.engine.plan.scans import Thinner
from hairpipe.engine.plan.tasks import Source, Task
from hairpipe.engine.store.digest import action_key
from hairpipe.engine.store.store import Output, Record

pytestmark = pytest.mark.usefixtures("kept")


def kept(shot) -> list[int]:
    results = shot.results()
    return [frame for frame in range(1, 11) if shot.store.has(results[f"sum@{frame}"]["state"])]


def test_every_nth_state_and_the_last_are_kept(shot):
    shot.run()
    assert kept(shot) == [4, 8, 10]
    shot.tally()
    shot.run()
    assert shot.tally() == Counter(), "a thinned state is no miss while nobody needs it"


SHOW = '''"""A look at a state."""
from numeral import Numeral, Sum
from tally import numeral, tally
from hairpipe.engine import node

@node(frames="each")
def show_sum(sum: Sum) -> Numeral:
    """Show it."""
    tally("show_sum")
    return numeral(sum.total)
'''


def show_states(shot):
    """Add a node that looks at the states of the scan."""
    (shot.nodes / "show_sum.py").write_text(SHOW)
    shot.add('[show]\ntype = "show_sum"\nin.sum = "sum"\n')


@pytest.mark.parametrize("twin", ["", '[twin]\nlike = "sum"\n'], ids=["one scan", "another scan has the same"])
def test_states_that_somebody_looks_at_stay_though_a_run_does_not_reach_him(shot, twin):
    show_states(shot)
    shot.change('in.numbers = "sum"', 'in.numbers = "move"')
    shot.add(twin)
    assert shot.run().exit_code == 0
    assert kept(shot) == list(range(1, 11))
    shot.run(to=["sum"])
    assert kept(shot) == list(range(1, 11))
    shot.tally()
    shot.run()
    assert shot.tally() == Counter()


def test_a_lost_state_is_computed_again_only_for_who_has_to_look_at_it(shot):
    show_states(shot)
    shot.run()
    states = [shot.results()[f"sum@{frame}"]["state"] for frame in (5, 6)]
    shot.tally()
    for state in states:
        shot.store.remove(shot.store.object_path(state))
    assert {entry.status for entry in shot.plan().values()} == {"cached"}
    shot.run()
    assert shot.tally() == Counter(), "nothing has changed, and nobody looks"
    shot.edit("show_sum.py", "sum.total", "2 * sum.total")
    planned = [name for name, entry in shot.plan().items() if entry.status == "run"]
    assert planned == ["sum@5", "sum@6", *(f"show@{frame}" for frame in range(1, 11))]
    shot.run()
    assert shot.tally()["add_up"] == 2 and kept(shot) == list(range(1, 11))


def test_state_that_is_needed_is_recomputed_from_the_nearest(shot):
    shot.run()
    before = shot.results()
    shot.tally()
    for frame in (4, 8, 10):
        shot.store.remove(shot.store.object_path(before[f"sum@{frame}"]["state"]))
    shot.change("[1, 10]", "[1, 11]")
    shot.run()
    assert shot.tally() == Counter(move_seed=1, add_up=11, write_list=1)
    after = shot.results()
    assert {name: after[name] for name in before if name != "list"} == {n: before[n] for n in before if n != "list"}


def store_of(there, has):
    """A store of some objects."""
    return SimpleNamespace(has=has, remove=there.discard, object_path=str, record_keys=lambda: (), record=None)


class Counted(dict):
    """Results that count how often one is looked at."""

    looks = 0

    def get(self, *given):
        self.looks += 1
        return super().get(*given)

    def values(self):
        self.looks += len(self)
        return super().values()

    def items(self):
        self.looks += len(self)
        return super().items()


@pytest.mark.parametrize("frames", [100, 10_000])
def test_each_state_is_looked_at_once(frames):
    """A scan of many frames costs in proportion to them."""
    there = {f"{frame}.h5" for frame in range(frames)}
    asked = []
    store = store_of(there, lambda name: asked.append(name) or name in there)
    node = SimpleNamespace(name="scan", checkpoint=24, settings={}, type=SimpleNamespace(name="add", mode="scan"))
    graph = SimpleNamespace(nodes={"scan": node}, frames=(0, frames - 1), begin=0)
    tasks = {Task("scan", frame): {} for frame in range(frames)}
    resolver = SimpleNamespace(graph=graph, store=store, results=Counted(), tasks=tasks, thinnable=lambda node: "state")
    thinner = Thinner(resolver)
    for task in tasks:
        outputs = {"state": Output(f"{task.frame}.h5", 1)}
        record = Record("", "scan", task.frame, {}, outputs, "state", 0.0, (), 0.0)
        resolver.results[task] = record
        thinner.add(task, record, None)
        thinner.thin_behind(task)
    thinner.thin_all()
    assert there == {f"{frame}.h5" for frame in range(frames) if frame % 24 == 23 or frame == frames - 1}
    assert len(asked) < frames and resolver.results.looks <= 2 * frames


def test_a_state_that_was_computed_again_is_let_go_of_again(shot):
    """Frames are evaluated again from the nearest checkpoint, in a run that had thinned them."""
    shot.run()
    shot.tally()
    for frame in (8, 10):
        shot.store.remove(shot.store.object_path(shot.results()[f"sum@{frame}"]["state"]))
    shot.change("[1, 10]", "[1, 11]")
    assert shot.run().exit_code == 0 and shot.tally()["add_up"] == 7
    results = shot.results()
    assert [f for f in range(1, 12) if shot.store.has(results[f"sum@{f}"]["state"])] == [4, 8, 11]


SHOWN = "@dataclass(frozen=True)\nclass Shown:\n    total: float\n    history: np.ndarray\n\n\n"


def test_a_state_that_is_shown_as_well_stays(shot):
    """One object, under two names of one result."""
    shot.edit("numeral.py", "@dataclass(frozen=True)\nclass Bent", SHOWN + "@dataclass(frozen=True)\nclass Bent")
    shot.edit("add_up.py", "import Numeral", "import Numeral, Shown")
    shot.edit("add_up.py", "Added(numeral(total), ", "Added(Shown(total, history), ")
    shot.edit("add_up.py", "    number: Numeral\n", "    number: Shown\n")
    shot.path.write_text(shot.path.read_text().split("[list]")[0])
    assert shot.run().exit_code == 0 and shot.tally()["add_up"] == 10
    assert kept(shot) == list(range(1, 11))


class TwoScans:
    """Two scans of one type and settings that share the first frames of six; states that there are."""

    def __init__(self, shared: int) -> None:
        self.there = {f"{name}{frame}" for name in ("a", "b") for frame in range(6)}
        self.shared = shared
        store = store_of(self.there, self.there.__contains__)
        kind = SimpleNamespace(name="add", mode="scan")
        nodes = {name: SimpleNamespace(name=name, checkpoint=24, settings={}, type=kind) for name in ("a", "b")}
        self.inputs = {Task(name, frame): Task(f"in_{name}", frame) for name in nodes for frame in range(6)}
        self.resolver = SimpleNamespace(
            graph=SimpleNamespace(nodes=nodes, frames=(0, 5), begin=0),
            store=store,
            results={},
            tasks={task: {"in": [Source(feed, "")]} for task, feed in self.inputs.items()},
            thinnable=lambda node: "state",
            parts=self.parts,
        )
        self.thinner = Thinner(self.resolver)

    def parts(self, task: Task) -> dict:
        return {"made": task.frame if task.frame < self.shared else [task.node, task.frame]}

    def feed(self, name: str, *frames: int) -> None:
        """Establish what goes into a scan."""
        self.resolver.results |= {self.inputs[Task(name, frame)]: None for frame in frames}

    def evaluate(self, name: str, *frames: int) -> None:
        for frame in frames:
            task, key = Task(name, frame), action_key(self.parts(Task(name, frame)))
            owner = "a" if frame < self.shared else name
            record = Record(key, name, frame, {}, {"state": Output(f"{owner}{frame}", 1)}, "state", 0.0, (), 0.0)
            self.resolver.results[task] = record
            self.thinner.add(task, record, None)
            self.thinner.thin_behind(task)

    def states(self, name: str) -> list[int]:
        return [frame for frame in range(6) if f"{name}{frame}" in self.there]


def test_shared_state_is_removed_when_scans_differ():
    scans = TwoScans(shared=3)
    scans.feed("a", *range(6))
    scans.evaluate("a", *range(6))
    assert scans.states("a") == [0, 1, 2, 3, 4, 5], "what goes into the other is not known yet"
    scans.feed("b", 0, 1, 2)
    scans.evaluate("b", 0, 1, 2)
    assert scans.states("a") == [1, 2, 3, 4, 5], "whether it shares frame 3 is not known yet"
    scans.feed("b", 3)
    scans.evaluate("b", 3)
    assert scans.states("a") == [2, 4, 5] and scans.states("b") == [0, 1, 2, 3, 4, 5]
    scans.evaluate("b", 4, 5)
    assert scans.states("a") == [4, 5] and scans.states("b") == [0, 1, 2, 4, 5]
    scans.thinner.thin_all()
    assert scans.states("a") == [5]


def test_a_state_is_written_where_another_scan_may_need_it():
    """The first frame that differs is known when the input of the other one is."""
    scans = TwoScans(shared=3)
    scans.resolver.demanded = set()
    scans.feed("a", *range(6))
    scans.feed("b", *range(4))
    written = []
    for frame in range(6):
        written.append(scans.thinner.must_write(Task("a", frame)))
        scans.evaluate("a", frame)
        if frame < 4:
            scans.evaluate("b", frame)
    assert written == [True, True, True, False, False, False]


def test_no_state_waits_for_a_scan_whose_first_frame_is_another():
    scans = TwoScans(shared=0)
    scans.feed("b", 0)
    scans.evaluate("a", *range(6))
    assert scans.states("a") == [4, 5]
