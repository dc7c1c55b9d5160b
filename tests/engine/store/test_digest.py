"""Keys: what is the same has the same, what differs has another."""

import math

import pytest

from hairpipe.engine.store.digest import action_key, canonical

BASE = {
    "type": "bake",
    "code": "c0de",
    "settings": {"voxel": 0.5, "name": "a", "map": {"file": "abc", "suffix": ".png"}},
    "inputs": {"body": ["one", "two"], "mask": None},
    "time": {"frame": 1, "fps": 24.0},
}


def key(**changes):
    return action_key(BASE | changes)


def test_order_of_names_does_not_count():
    assert key(settings=dict(reversed(BASE["settings"].items()))) == key()
    assert len(key()) == 40


@pytest.mark.parametrize(
    "change",
    [
        {"type": "bake2"},
        {"code": "c0df"},
        {"settings": BASE["settings"] | {"voxel": 0.25}},
        {"settings": BASE["settings"] | {"map": None}},
        {"inputs": {"body": ["two", "one"], "mask": None}},
        {"inputs": {"body": ["one", "two"], "mask": "one"}},
        {"inputs": {"body": "one", "mask": None}},
        {"time": {"frame": 2, "fps": 24.0}},
        {"time": None},
    ],
)
def test_every_part_counts(change):
    assert key(**change) != key()


def test_values_of_different_types_stay_apart():
    values = [1, 1.0, "1", True, None, "", [], {}, [1], ["1"], [[1]], {"a": 1}, 0, 0.0, -0.0, False, "None"]
    texts = [canonical(value) for value in values]
    assert len(set(texts)) == len(values)


def test_values_without_a_canonical_text_are_refused():
    for value in (math.nan, math.inf, [math.inf]):
        with pytest.raises(ValueError):
            canonical(value)
    for value in ({1: "a"}, b"x", {1, 2}, object(), {"a": [{None: 1}]}):
        with pytest.raises(TypeError):
            canonical(value)
