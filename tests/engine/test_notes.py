"""Notes of a store: what was noted, or nothing."""

import pytest

from hairpipe.engine.store.store import Store

NAME, OTHER = "a" * 40, "b" * 40


@pytest.fixture
def store(tmp_path):
    store = Store(tmp_path)
    store.note(NAME, '["code", {"x": null}, [["studio.soft", "f"]]]')
    return store


def path_of(store, name):
    return store.root / "notes" / name[:2] / name


def test_a_note_is_given_back(store):
    assert store.recall(NAME) == '["code", {"x": null}, [["studio.soft", "f"]]]'
    assert store.recall(OTHER) is None


@pytest.mark.parametrize(
    ("old", "new"), [(", [[", ", [("), (', [[\\"studio.soft\\", \\"f\\"]]', ", []"), ("soft", "loft")]
)
def test_a_damaged_note_is_none_and_is_made_again(store, old, new):
    path = path_of(store, NAME)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    assert store.recall(NAME) is None
    assert store.remember(NAME, lambda: "again") == "again" == store.recall(NAME)


def test_a_note_is_none_of_another_name(store):
    store.note(OTHER, "other")
    path_of(store, OTHER).write_bytes(path_of(store, NAME).read_bytes())
    assert store.recall(OTHER) is None


@pytest.mark.parametrize("data", [b"\xff", b"{", b"3", b"[]", b"{}", b'{"note": "other"}', b'{"note": 3, "digest": 3}'])
def test_invalid_notes_are_none(store, data):
    path_of(store, NAME).write_bytes(data)
    assert store.recall(NAME) is None
