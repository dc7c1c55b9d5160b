"""What a plan says of two keys that differ."""

import pytest

from hairpipe.engine.plan import key
from hairpipe.engine.plan.key import differing_versions, input_differences, setting_differences

FILE, OTHER = {"file": "a1", "suffix": ".bvh"}, {"file": "b2", "suffix": ".bvh"}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ({"step": 1.0, "turn": 2}, {"step": 1.0, "turn": 2}, []),
        ({"step": 1.0}, {"step": 2.0}, ["setting step 1.0 -> 2.0"]),
        ({"bent": {"by": 1, "at": 2}}, {"bent": {"by": 3, "at": 2}}, ["setting bent.by 1 -> 3"]),
        ({"clip": FILE}, {"clip": OTHER}, ["contents of the file of setting clip"]),
        ({"b": 1, "a": 1}, {"b": 2, "a": 2}, ["setting a 1 -> 2", "setting b 1 -> 2"]),
    ],
)
def test_settings_are_compared_by_name_and_field(old, new, said):
    assert list(setting_differences(old, new, "setting ")) == said


@pytest.mark.parametrize(("old", "new"), [(None, {"by": 1}), ({"by": 1}, None), (1, {"by": 1}), (FILE, None)])
def test_a_group_that_comes_or_goes_is_one_difference(old, new):
    [said] = setting_differences({"bent": old}, {"bent": new}, "setting ")
    assert said.startswith("setting bent ") and " -> " in said


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("a", "a", []),
        ("a", "b", ["input hair"]),
        (None, "a", ["input hair connected"]),
        ("a", None, ["input hair disconnected"]),
        (["a", "b"], ["a", "c"], ["input hair"]),
        ([[1, "a"], [2, "b"]], [[1, "a"], [2, "c"]], ["input hair at frame 2"]),
        ([[1, "a"], [2, "b"], [3, "c"]], [[1, "x"], [2, "y"], [3, "z"]], ["input hair at frame 1 and 2 more"]),
        ([[1, "a"], [2, "b"]], [[2, "b"], [3, "c"]], ["input hair frames 1-2 -> 2-3"]),
        ([[1, "a"]], ["a", "b"], ["input hair"]),
    ],
)
def test_inputs_are_compared_frame_by_frame(old, new, said):
    assert list(input_differences({"hair": old}, {"hair": new})) == said


def test_versions_of_a_choice_that_differ_are_named_also_within_groups(monkeypatch):
    monkeypatch.setattr(key, "version", {"blender": "5.0", "usd": "26.3"}.__getitem__)
    same, old = ({"choice": "c", "versions": {"blender": number, "usd": "26.3"}} for number in ("5.0", "4.2"))
    assert differing_versions({"device": same, "size": 3}) == {}
    assert differing_versions({"size": 3, "look": {"device": old}}) == {"blender": "4.2"}
