"""Wedges as graph files state them: which variants there are, what they are called, and what is refused."""

from pathlib import Path

import pytest

from hairpipe.engine.file.read import GraphText
from hairpipe.engine.file.wedge import find_wedge, read_wedges
from hairpipe.errors import BadInput

GRAPH = """schema = 1
[seed]
type = "make_seed"
[move]
type = "move_seed"
[weight]
type = "weigh"
[wedge.first]
axes.seed.value = [1, 2]
[wedge.grip]
"""


def wedge(text):
    return find_wedge(GraphText(Path("shot.toml"), GRAPH + text), "grip")


def values(axis):
    return wedge(f"axes.seed.value = {axis}").axes["seed.value"]


def test_axes_are_crossed_the_last_one_first_and_joint_ones_vary_together():
    axes = "axes.seed.value = [1, 2]\naxes.move.step = [0.5, 1.0]"
    found = wedge(axes).variants
    assert list(found) == ["value=1,step=0.5", "value=1,step=1", "value=2,step=0.5", "value=2,step=1"]
    assert found["value=2,step=0.5"] == {"seed.value": 2, "move.step": 0.5}
    found = wedge(f"joint = true\n{axes}").variants
    assert list(found.values()) == [{"seed.value": 1, "move.step": 0.5}, {"seed.value": 2, "move.step": 1.0}]


def test_a_setting_may_be_one_quoted_name_and_its_value_is_the_setting():
    assert wedge('axes."seed.bent.strength" = [1]').axes == wedge("axes.seed.bent.strength = [1]").axes
    one, other = (wedge(f"axes.seed.{name} = [1, 2]") for name in ("bent", "bent.value"))
    assert one.variants == other.variants == {"bent=1": {"seed.bent": 1}, "bent=2": {"seed.bent": 2}}


def test_a_range_has_the_numbers_that_one_would_write():
    assert values("{ from = 0.1, to = 0.3, count = 3 }") == (0.1, 0.2, 0.3)
    assert values("{ from = 0.001, to = 10, count = 5, log = true }") == (0.001, 0.01, 0.1, 1.0, 10.0)
    assert values("{ from = 9, to = 1, count = 3 }") == (9, 5, 1) and type(values("[5]")[0]) is int
    assert values("{ from = 0, to = 1, count = 3 }") == (0.0, 0.5, 1.0)


def test_random_values_are_those_of_a_seed_and_of_a_setting():
    drawn = "{ random = { from = 0.1, to = 10.0, count = 200, log = true }, seed = 3 }"
    found = values(drawn)
    assert found == values(drawn) != values(drawn.replace("3 }", "4 }"))
    assert all(0.1 <= value <= 10.0 for value in found)
    assert 70 < sum(value < 1.0 for value in found) < 130, "in equal ratios half of them are below the middle one"
    assert wedge(f"axes.seed.bent.strength = {drawn}").axes["seed.bent.strength"] != found


def test_a_condition_leaves_variants_out():
    text = "axes.seed.value = [1, 2, 3]\naxes.move.step = [1, 2, 3]\n"
    found = wedge(f'{text}where = [["seed.value", "<", "step"], ["move.step", "!=", 2]]').variants
    assert list(found) == ["value=1,step=3", "value=2,step=3"]


def test_names_are_short_and_part_of_a_file_name():
    found = wedge('axes.seed.value = [1e-6]\naxes.move.value = [true]\naxes.move.file = ["a b/c.bvh"]').variants
    (name,) = found
    assert name.startswith("seed.value=1e-06,move.value=true,file=a-b-c.bvh-") and "/" not in name
    (other,) = wedge('axes.seed.value = [1e-6]\naxes.move.value = [true]\naxes.move.file = ["a-b-c.bvh"]').variants
    assert other == "seed.value=1e-06,move.value=true,file=a-b-c.bvh"
    long = list(wedge(f'axes.seed.file = ["{"x" * 400}", "{"x" * 401}"]').variants)
    assert len(set(long)) == 2 and all(len(name) <= 120 for name in long)


def test_a_criterion_names_a_column_as_it_is_written():
    (criterion,) = wedge('axes.seed.value = [1]\nstop = [["weight.of all [kg/m.s]", ">=", 3]]').stop
    assert criterion == ("weight.of all [kg/m.s]", ">=", 3)


AXIS = "axes.seed.value = [1, 2]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"shot.toml:10: \[wedge.grip\]: no axes"),
        ("axes = []", "axes = .* is not a table of axes"),
        ("axes.sed.value = [1]", r"cannot set 'sed.value' \(did you mean 'seed'\?\)"),
        ("axes.seed = [1]", "cannot set 'seed'"),
        ('axes.seed.type = ["weigh"]', "cannot set 'seed.type'"),
        ("axes.seed.value = []", r"shot.toml:11: \[wedge.grip\]: axes: seed.value: no values"),
        ("axes.seed.value = [1, 1.0]", "1.0 occurs twice"),
        ("axes.seed.value = 3", "3 is not an axis"),
        ("axes.seed.value = { from = 1, to = 2 }", r"seed.value: .* \({ from = "),
        ("axes.seed.value = { from = 1, to = 2, count = 0 }", "count = 0"),
        ("axes.seed.value = { from = 0, to = 2, count = 3, log = true }", "log = true from 0 to 2"),
        ("axes.seed.value = { random = { from = 0, to = 2, count = 3 } }", "random = .* seed = 1"),
        (AXIS + 'axes."seed.value.x" = [1]', "two of 'seed.value'"),
        (AXIS + "joint = true\naxes.move.step = [1]", r"different lengths \(seed.value: 2, move.step: 1\)"),
        (AXIS + "joint = 1", "joint = 1"),
        (AXIS + "axes.move.step = { from = 0, to = 1, count = 501 }", "1,002 variants are too many"),
        (AXIS + "sow = []", r"unknown key 'sow' \(did you mean 'show'\?\)"),
        (AXIS + 'show = ["mov"]', r"show: no node 'mov' \(did you mean 'move'\?\)"),
        (AXIS + 'measures = "weight"', "measures = 'weight'"),
        (AXIS + 'where = [["value", "<", 1]]', "no variant is left"),
        (AXIS + 'where = [["move.step", "<", 1]]', "no axis 'move.step'"),
        (AXIS + 'where = [["value", "<", "x"]]', "cannot be compared"),
        (AXIS + 'where = [["value", "=", 1]]', r"'=' is not a relation \(one of < <="),
        (AXIS + 'where = ["value < 1"]', "is not a comparison"),
        (AXIS + 'stop = [["wait.x", ">", 1]]', r"stop: no node 'wait' \(did you mean 'weight'\?\)"),
        (AXIS + 'stop = [["weight", ">", 1]]', "is not the name of a column"),
        (AXIS + 'stop = [["weight.x", ">", "heavy"]]', "is not a number"),
    ],
)
def test_faults_are_reported_with_their_place(text, message):
    with pytest.raises(BadInput, match=message):
        wedge(text)


def test_unknown_wedges_and_nodes_called_wedge_are_reported():
    with pytest.raises(BadInput, match=r"no wedge 'gripp' \(did you mean 'grip'\?\)"):
        find_wedge(GraphText(Path("shot.toml"), GRAPH + AXIS), "gripp")
    for text in ("wedge = 1", "[wedge]\ntype = 'make_seed'", "[wedge.'a b']\n"):
        with pytest.raises(BadInput, match="is not a wedge"):
            read_wedges(GraphText(Path("shot.toml"), text))
