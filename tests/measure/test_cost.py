"""What frames cost is read from what their results took."""

import inspect
import math

import pytest

from hairpipe.engine import Reached, Spent
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.around import Around
from hairpipe.graphs.experiments.nodes.restart_hair import restart_hair
from hairpipe.measure.motion import COST_COLUMNS
from hairpipe.nodes.measure_cost import measure_cost
from hairpipe.nodes.simulate_hair import simulate_hair


def spent(seconds):
    """Give what frames from 5 on took: all threads twice as long as what passed."""
    taken = {frame: Spent(value / 2, value) for frame, value in enumerate(seconds, 5)}
    return Reached(tuple(taken), taken.__getitem__)


def row(table):
    return [table[name][0] for name in COST_COLUMNS]


def test_the_first_frames_do_not_count_and_nodes_add_up():
    table = measure_cost((spent([9.0, 8.0, 1.0, 2.0, 6.0, 7.0]), spent([1.0] * 6)), warm=1, timed=3)
    assert row(table) == [3.0, 2.0, 7.0, 3]


@pytest.mark.parametrize("seconds", [[9.0, 3.0], [9.0, 4.0, 3.0]])
def test_a_shot_of_few_frames_is_timed_by_its_last(seconds):
    assert row(measure_cost((spent(seconds),), warm=4, timed=8)) == [3.0, 3.0, 3.0, 1]


def test_one_frame_alone_has_no_cost():
    first, *_, count = row(measure_cost((spent([9.0]),)))
    assert math.isnan(first) and count == 0


def test_a_node_that_diverged_ends_the_measurement():
    table = measure_cost((spent([9.0, 1.0, 2.0]), spent([9.0, 1.0, 2.0, 3.0, 4.0])), warm=1, timed=8)
    assert row(table) == [4.0, 4.0, 4.0, 1]


def test_a_restart_takes_the_settings_of_the_simulation():
    ours, theirs = (inspect.signature(function).parameters for function in (restart_hair, simulate_hair))
    settings = {name: (p.annotation, p.default) for name, p in theirs.items() if p.kind is p.KEYWORD_ONLY}
    assert settings.items() <= {name: (p.annotation, p.default) for name, p in ours.items()}.items()


def test_frames_that_are_omitted_are_refused_where_hair_would_restart():
    shot = Reached((5, 6, 9), lambda frame: frame)
    assert Around(None, shot, (), ()).frames(5, 2) == [5, 6]
    with pytest.raises(BadInput, match=r"no frames between 6 and 9.*\(4 of them in a row\)"):
        Around(None, shot, (), ()).frames(5, 4)
