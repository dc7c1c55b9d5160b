"""Damaged results: noticed when they are used, computed again, never an error."""

import os
import resource
import struct
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import pytest

from hairpipe.graph import File
from hairpipe.graph.keep import is_whole, verify
from hairpipe.graph.store import Store
from hairpipe.graph.values import Values
from hairpipe.io import hdf5
from hairpipe.io.hdf5 import digest_file


def flip(path):
    """Flip a bit of the array in a value, or of the middle of anything else: some of HDF5 is padding."""
    data = bytearray(path.read_bytes())
    at = max(data.find(struct.pack("<2d", value, value)) for value in (3.0, 9.0))
    data[at if at > 0 else len(data) // 2] ^= 16
    rewrite(path, bytes(data))


def truncate(path):
    rewrite(path, path.read_bytes()[:-7])


def rewrite(path, data):
    path.chmod(0o644)
    path.write_bytes(data)


def remove(path):
    path.unlink()


@pytest.mark.parametrize("harm", [flip, truncate, remove])
def test_damaged_value_is_computed_again(shot, harm):
    shot.run()
    before = shot.results()
    shot.tally()
    harm(shot.store.object_path(before["move@6"][""]))
    shot.run(sum__warn=99)
    counts = shot.tally()
    assert counts == Counter(move_seed=1, add_up=10)
    assert shot.results() == before


@pytest.mark.parametrize("harm", [flip, truncate, remove])
def test_damaged_file_is_published_whole(shot, harm):
    shot.run()
    published = shot.folder / "out" / "list.txt"
    right = published.read_bytes()
    shot.tally()
    harm(shot.store.object_path(shot.results()["list"][""]))
    published.unlink()
    assert shot.run().exit_code == 0
    assert shot.tally() == Counter(write_list=1)
    assert published.read_bytes() == right


@pytest.mark.parametrize("harm", [flip, truncate, remove])
def test_damaged_record_is_a_miss(shot, harm):
    shot.run()
    record = next(
        shot.store.record(p.stem) for p in shot.store.root.glob("actions/??/*.json") if '"move"' in p.read_text()
    )
    shot.tally()
    harm(shot.store.action_path(record.key))
    shot.run()
    assert shot.tally() == Counter(move_seed=1)


def test_damaged_notes_cost_nothing_but_time(shot):
    shot.run()
    shot.tally()
    for path in [*shot.store.root.glob("notes/??/*"), *shot.store.root.glob("latest/*/*")]:
        path.write_bytes(b"\xff{")
    assert shot.run().exit_code == 0
    assert shot.tally() == Counter()


def test_verify_finds_and_removes_what_is_damaged(shot):
    shot.run()
    results = shot.results()
    assert verify(shot.store, digest_file) == []
    record = next(shot.store.root.glob("actions/??/*.json"))
    record.write_text("garbage")
    flip(shot.store.object_path(results["seed"][""]))
    truncate(shot.store.object_path(results["list"][""]))
    found = verify(shot.store, digest_file)
    objects = [f"objects/{results[name]['']}" for name in ("seed", "list")]
    assert sorted(found) == sorted([f"actions/{record.name}", *objects]) and not record.exists()
    shot.run()
    assert shot.results() == results
    assert verify(shot.store, digest_file) == []


@pytest.fixture
def no_more_files():
    """Nothing can be opened any more."""
    free = os.open(os.devnull, os.O_RDONLY)
    os.close(free)
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (free, limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, limits)


@dataclass(frozen=True)
class Number:
    """A value."""

    value: float


HERE = Path(__file__)


@pytest.mark.parametrize("value", [Number(1.0), File(HERE), File(HERE, {"beside": HERE})])
def test_what_the_system_does_not_let_be_read_is_not_damaged(tmp_path, request, value):
    store, kind = Store(tmp_path), type(value)
    path = store.object_path(Values(store, hdf5, 0).put(value, kind, None).object)
    request.getfixturevalue("no_more_files")
    with pytest.raises(OSError, match="Too many open files"):
        Values(store, hdf5, 0).get(path.name, kind)
    with pytest.raises(OSError, match="Too many open files"):
        is_whole(path, hdf5.digest_file)
    assert path.exists()


def test_store_is_remade_from_nothing_but_a_folder(shot):
    store = Store(shot.folder / "deep" / "new")
    assert shot.run(store=store, to=["seed"]).exit_code == 0
