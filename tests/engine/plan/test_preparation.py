"""What a node is prepared with: once a worker, from values for the shot and settings, and nowhere stored."""

from collections import Counter
from dataclasses import dataclass

import numpy as np
import pytest

from hairpipe.engine import Time, node
from hairpipe.engine.plan.arguments import Preparations, Prepared, nbytes_of
from hairpipe.errors import BadInput

SCALE = '''"""A fold whose factor is made once."""
import warnings
from typing import NamedTuple
from numeral import Numeral, Sum
from tally import numeral, tally
from hairpipe.engine import Time, node
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


def test_its_warnings_are_reported_once_also_where_a_run_continues(prepared):
    for frames in (range(1, 6), None, None):
        prepared.run(frames)
        assert prepared.warned == [("scale@1", "the factor is large")]
    assert prepared.tally()["make_factor"] == 2, "a worker a run"


def test_its_failure_is_one_of_the_node(prepared):
    (failure,) = prepared.run(scale__fail="true").failures
    assert (failure.kind, str(failure)) == ("node", "scale@1: KeyError: 'no factor'")
    assert "in make_factor" in failure.traceback


def test_values_per_frame_prepare_nothing(prepared):
    prepared.change('in.seed = "seed"\nin.number', 'in.seed = "move"\nin.number')
    place = r"13: \[scale\] scale: in.seed: "
    with pytest.raises(BadInput, match=f"{place}'move' gives a value per frame, 'scale' is prep"):
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


def test_a_node_stays_a_plain_function():
    assert plain([1], [4], Time(1, 24.0)) == [4]


def test_scans_that_advance_in_turn_are_prepared_once_each(prepared):
    powers = {"second": 3, "third": 4, "fourth": 5}
    scans = [f'[{name}]\nlike = "scale"\npower = {power}\n' for name, power in powers.items()]
    prepared.add("\n".join(["", *scans]))
    assert prepared.run(jobs=1).exit_code == 0
    assert prepared.tally() == Counter(make_seed=1, move_seed=10, make_factor=4, scale=40)


@pytest.mark.parametrize(("memory", "forgotten"), [(0, ["b"]), (119, ["b"]), (120, []), (1000, [])])
def test_the_latest_preparations_are_kept_within_the_memory(memory, forgotten):
    """Each of the three takes 40 bytes."""
    loaded, preparations = [], Preparations(memory)

    def prepare(name):
        def load(name, kind):
            loaded.append(name)
            return [name, np.zeros(5)]

        preparations.prepare(plain.__node__, {"seed": name}, {"power": 2, "offset": 0.0}, load)

    for name in "abaca":
        prepare(name)
    assert loaded == ["a", "b", "c"]
    loaded.clear()
    for name in "acb":
        prepare(name)
    assert loaded == forgotten, "the last two are kept in any memory"


def test_arrays_are_counted_once_and_views_as_what_they_hold():
    array = np.zeros(100)
    assert nbytes_of({"whole": array, "part": array[:3], "again": [array]}) == 800
    assert nbytes_of(Prepared({"value": Items()})) == 0
