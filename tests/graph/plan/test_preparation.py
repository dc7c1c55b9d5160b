"""What a node is prepared with: once a worker, from values for the shot and settings, and nowhere stored."""

from collections import Counter
from dataclasses import dataclass

import pytest

from hairpipe.errors import BadInput
from hairpipe.graph import Time, node
from hairpipe.graph.plan.preparation import Preparations

SCALE = '''"""A fold whose factor is made once."""
import warnings
from typing import NamedTuple
from numeral import Numeral, Sum
from tally import numeral, tally
from hairpipe.graph import Time, node
from worth import worth

class Factor(NamedTuple):
    """What is made once."""
    value: float

def make_factor(seed: Numeral, power: int, fail: bool) -> Factor:
    """Make the factor."""
    tally("make_factor")
    if fail:
        raise KeyError("no factor")
    warnings.warn("the factor is large")
    seed.load[:] = -1.0
    return Factor(worth(seed.value) ** power)

@node(frames="scan", prepare=make_factor)
def scale(seed: Numeral, number: Numeral, previous: Sum | None, prepared: Factor, time: Time, *,
          power: int = 2, fail: bool = False, offset: float = 0.0) -> Sum:
    """Scale a number, and add it up."""
    tally("scale", time.frame)
    assert seed.load[0] == 3.0
    total = prepared.value * number.value + offset + (previous.total if previous else 0.0)
    return Sum(total, seed.load)
'''
GRAPH = '[scale]\ntype = "scale"\nin.seed = "seed"\nin.number = "move"\n'


@pytest.fixture
def prepared(shot):
    """The shot with a scan in place of its own whose factor is made once."""
    (shot.nodes / "scale.py").write_text(SCALE)
    (shot.nodes / "worth.py").write_text("def worth(value):\n    return value\n")
    shot.path.write_text(shot.path.read_text().partition("[sum]")[0] + GRAPH)
    return shot


def test_prepare_is_called_once_for_all_frames_and_again_for_a_changed_setting(prepared):
    assert prepared.run().exit_code == 0
    assert prepared.tally() == Counter(make_seed=1, move_seed=10, make_factor=1, scale=10)
    names = {path.name for path in prepared.store.root.glob("objects/*/*")}
    assert names == {name for outputs in prepared.results().values() for name in outputs.values()}, "and not stored"
    prepared.run(scale__power=3)
    assert prepared.tally() == Counter(make_factor=1, scale=10)
    prepared.edit("worth.py", "return value", "return 2.0 * value")
    prepared.run()
    assert prepared.tally() == Counter(make_factor=1, scale=10), "its code is code of the node"


def test_its_warnings_are_reported_once_also_where_a_run_goes_on(prepared):
    def warned(**given):
        events = []
        prepared.run(report=events.append, **given)
        return [(str(event.task), event.message) for event in events if event.kind == "warning"]

    once = [("scale@1", "the factor is large")]
    assert [warned(frames=range(1, 6)), warned(), warned()] == [once] * 3
    assert prepared.tally()["make_factor"] == 2, "a worker a run"


def test_its_failure_is_one_of_the_node(prepared):
    (failure,) = prepared.run(scale__fail="true").failures
    assert (failure.kind, str(failure)) == ("node", "scale@1: KeyError: 'no factor'")
    assert "in make_factor" in failure.traceback


def test_values_per_frame_prepare_nothing(prepared):
    text = prepared.path.read_text()
    prepared.path.write_text(text.replace('in.seed = "seed"\nin.number', 'in.seed = "move"\nin.number'))
    with pytest.raises(
        BadInput, match=r"13: \[scale\] scale: in.seed: 'move' gives a value per frame, 'scale' is prep"
    ):
        prepared.load()


@dataclass(frozen=True)
class Items:
    """A value, for which a list stands in."""


def double(seed: Items, power: int) -> Items:
    """Give a list."""
    return [*seed, power]


@node(frames="each", prepare=double)
def plain(seed: Items, prepared: Items, time: Time, *, power: int = 2, offset: float = 0.0) -> Items:
    """Return what it was given."""
    return prepared


def test_a_node_stays_a_plain_function_and_the_last_two_preparations_are_kept():
    assert plain([1], [4], Time(1, 24.0)) == [4]
    loaded, preparations = [], Preparations()

    def prepare(name, **settings):
        def load(name, kind):
            loaded.append(name)
            return [name]

        given = {"power": 2, "offset": 0.0} | settings
        return preparations.prepare(plain.__node__, {"seed": name}, given, load).arguments["prepared"]

    assert [prepare("a"), prepare("b"), prepare("a", offset=1.0), prepare("a", power=3)] == [
        ["a", 2],
        ["b", 2],
        ["a", 2],
        ["a", 3],
    ]
    assert loaded == ["a", "b", "a"]
    prepare("a")
    prepare("b")
    assert loaded == ["a", "b", "a", "b"], "the third pushed the one out that was not used for longest"
