"""The store among processes that change it at the same time."""

import errno
from pathlib import Path


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
