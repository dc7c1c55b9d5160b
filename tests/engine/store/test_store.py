"""The store among processes that change it at the same time."""

import errno
from pathlib import Path

from hairpipe.engine.store.store import Store


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
