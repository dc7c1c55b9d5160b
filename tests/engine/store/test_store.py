"""The store: records, objects and notes, among processes that change it, and of other versions."""

import errno
import json
from pathlib import Path

import pytest

from hairpipe.engine.store.digest import digest_bytes
from hairpipe.engine.store.store import MARK, Output, Record, Store, read_record, write_record


def test_a_record_that_is_added_while_it_is_looked_for_is_kept(shot, monkeypatch):
    """It was taken for something that lies in the place of a record, and removed."""
    shot.run(to=["seed"])
    (key,) = shot.store.record_keys()
    place = shot.store.action_path(key)
    aside = place.rename(shot.folder / "aside")
    stat = Path.stat

    def added_after_a_look(path, **words):
        if path == place and aside.exists():
            aside.rename(place)
            raise FileNotFoundError(errno.ENOENT, "not there yet", str(path))
        return stat(path, **words)

    monkeypatch.setattr(Path, "stat", added_after_a_look)
    assert shot.store.record(key) is None
    assert shot.store.record(key).key == key


def test_room_is_made_for_a_file_and_a_file_that_is_there_stays(tmp_path):
    store = Store(tmp_path / "store")
    place = store.room(store.root / "notes" / "ab" / "name")
    place.write_text("text")
    assert store.room(place).read_text() == "text"
    place.unlink()
    (place / "inner").mkdir(parents=True)
    assert not store.room(place).exists()


def test_a_link_to_nothing_in_the_place_of_a_record_is_damage(tmp_path):
    store = Store(tmp_path)
    place = store.room(store.action_path("0c" * 20))
    assert store.record("0c" * 20) is None
    place.symlink_to(tmp_path / "nothing")
    assert store.record("0c" * 20) is None and not place.is_symlink()


def test_an_object_of_another_size_is_damage(tmp_path):
    store, name = Store(tmp_path), f"{'0c' * 20}.bin"
    store.room(store.object_path(name)).write_bytes(b"abc")
    assert store.has(name) and store.has(name, 3) and store.size(name) == 3
    assert not store.has(name, 4) and not store.has(name) and not store.has(name, 3)


PARTS = {"type": "toy", "code": "c", "settings": {}, "inputs": {}, "time": None}
RECORD = Record("a" * 40, "hair", 7, PARTS, {"": Output("b" * 40 + ".h5", 3)}, None, 1.5, ("odd",), 1e9, 1.25)


def test_a_record_is_read_as_it_was_written():
    assert read_record(write_record(RECORD)) == RECORD


def of_another_version(change):
    """Read a record with fields that were changed before it was written."""
    fields = json.loads(write_record(RECORD))
    del fields["check"]
    change(fields)
    text = json.dumps(fields, separators=(",", ":"))
    return read_record(f'{text[:-1]}{MARK}{digest_bytes("record", text.encode())}"}}')


def test_a_record_of_an_older_version_lacks_the_seconds_of_the_processor():
    found = of_another_version(lambda fields: fields.pop("processor"))
    assert found is not None and found.processor is None and found.seconds == 1.5


def test_a_record_of_a_newer_version_is_read_but_for_what_is_new():
    assert of_another_version(lambda fields: fields.update(memory=7)) == RECORD


def test_a_record_with_a_changed_byte_is_none():
    assert read_record(write_record(RECORD).replace("1.5", "1.6")) is None


NAME, OTHER = "a" * 40, "b" * 40


@pytest.fixture
def noted(tmp_path):
    """A store with a note."""
    store = Store(tmp_path)
    store.note(NAME, '["code", {"x": null}, [["studio.soft", "f"]]]')
    return store


def path_of(store, name):
    return store.root / "notes" / name[:2] / name


def test_a_note_is_given_back(noted):
    assert noted.recall(NAME) == '["code", {"x": null}, [["studio.soft", "f"]]]'
    assert noted.recall(OTHER) is None


@pytest.mark.parametrize(
    ("old", "new"), [(", [[", ", [("), (', [[\\"studio.soft\\", \\"f\\"]]', ", []"), ("soft", "loft")]
)
def test_a_damaged_note_is_none_and_is_made_again(noted, old, new):
    path = path_of(noted, NAME)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    assert noted.recall(NAME) is None
    assert noted.remember(NAME, lambda: "again") == "again" == noted.recall(NAME)


def test_a_note_is_none_of_another_name(noted):
    noted.note(OTHER, "other")
    path_of(noted, OTHER).write_bytes(path_of(noted, NAME).read_bytes())
    assert noted.recall(OTHER) is None


@pytest.mark.parametrize("data", [b"\xff", b"{", b"3", b"[]", b"{}", b'{"note": "other"}', b'{"note": 3, "digest": 3}'])
def test_invalid_notes_are_none(noted, data):
    path_of(noted, NAME).write_bytes(data)
    assert noted.recall(NAME) is None
