"""Damaged results: noticed when they are used, computed again, never an error."""

import errno
import json
import os
import resource
import shutil
import struct
from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import pytest

from hairpipe.engine import File
from hairpipe.engine.plan.maintenance import Found, is_whole, verify
from hairpipe.engine.run.publish import files_of
from hairpipe.engine.store.atomic import write_text
from hairpipe.engine.store.digest import digest, digest_bytes
from hairpipe.engine.store.store import MARK, LostObject, Store, read_record, write_record
from hairpipe.engine.store.values import Values, check_name, read_listing
from hairpipe.formats import hdf5
from hairpipe.formats.hdf5 import digest_file


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
def test_damaged_files_values_and_records_are_computed_again(shot, harm):
    """One after another, in one store: each time what is damaged, and nothing else."""
    shot.run()
    before, published = shot.results(), shot.folder / "out" / "list.txt"
    right, record = published.read_bytes(), shot.plan()["move@3"].key
    shot.tally()
    harm(shot.store.object_path(before["list"][""]))
    published.unlink()
    assert shot.run().exit_code == 0 and shot.tally() == Counter(write_list=1) and published.read_bytes() == right
    harm(shot.store.action_path(record))
    assert shot.run().exit_code == 0 and shot.tally() == Counter(move_seed=1)
    harm(shot.store.object_path(before["move@6"][""]))
    assert shot.run(sum__warn=99).exit_code == 0 and shot.tally() == Counter(move_seed=1, add_up=10)
    for path in [*shot.store.root.glob("notes/??/*"), *shot.store.root.glob("latest/*/*")]:
        path.write_bytes(b"\xff{")
    assert shot.run().exit_code == 0 and shot.tally() == Counter(), "damaged notes cost nothing but time"
    assert shot.results() == before


def test_verify_finds_and_removes_what_is_damaged(shot):
    shot.run()
    results = shot.results()
    assert verify(shot.store, digest_file) == Found()
    record = next(shot.store.root.glob("actions/??/*.json"))
    record.write_text("garbage")
    flip(shot.store.object_path(results["seed"][""]))
    truncate(shot.store.object_path(results["list"][""]))
    found = verify(shot.store, digest_file).damaged
    objects = [f"objects/{results[name]['']}" for name in ("seed", "list")]
    assert sorted(found) == sorted([f"actions/{record.name}", *objects]) and not record.exists()
    shot.run()
    assert shot.results() == results
    assert verify(shot.store, digest_file) == Found()


@pytest.fixture
def listed(shot):
    """The shot after a run that has published a file with a companion: the listing, its record, what was published."""
    assert shot.run(list__parts="true").exit_code == 0
    record = next(r for r in map(shot.store.record, shot.store.record_keys()) if r.node == "list")
    return shot.store.object_path(record.outputs[""].object), record, published(shot)


def published(shot):
    return {str(path.relative_to(shot.folder)): path.read_bytes() for path in shot.folder.glob("out/**/*.txt")}


def flips(data):
    """Every state of some bytes in which one bit is another."""
    for bit in range(8 * len(data)):
        yield data[: bit // 8] + bytes([data[bit // 8] ^ 1 << bit % 8]) + data[bit // 8 + 1 :]


def test_no_flipped_bit_of_a_listing_is_believed(shot, listed):
    """It is lost, and removed, or says what it said."""
    path, record, _ = listed
    data, place = path.read_bytes(), shot.folder / "elsewhere" / "list.txt"
    right = files_of(shot.store, record.outputs[""], place)
    lost = 0
    for damaged in flips(data):
        rewrite(path, damaged)
        try:
            assert files_of(shot.store, record.outputs[""], place) == right
        except LostObject:
            lost += 1
            assert not path.exists()
            path.touch()
    assert lost > 7.5 * len(data)


@pytest.mark.parametrize("at", ["companions", "txt", "bin", "set"])
def test_a_damaged_listing_is_made_again(shot, listed, at):
    path, _, right = listed
    data = path.read_bytes()
    rewrite(path, data.replace(b"parts/", b"qarts/") if at == "set" else data.replace(at.encode(), at.encode()[:-1]))
    shutil.rmtree(shot.folder / "out")
    shot.tally()
    assert shot.run(list__parts="true").exit_code == 0
    assert shot.tally() == Counter(write_list=1) and published(shot) == right


def test_no_flipped_bit_of_a_record_is_believed(shot, listed):
    _, record, _ = listed
    text = shot.store.action_path(record.key).read_bytes()
    assert all(read_record(damaged.decode(errors="replace")) is None for damaged in flips(text))


AWAY = ["../up", "/etc/cron.d/job", "a/../../b", "", ".", "a/", "a//b", "a\nb", "\x1b[2J", "\0", "\ud800", "\x9b"]


def test_a_listing_leads_nowhere(shot, listed):
    """Though its name be that of what it says: somebody else may have written it."""
    path, _, _ = listed
    right = json.loads(path.read_text())
    for label in AWAY:
        listing = right | {"companions": {label: right["path"]}}
        name = digest("set", listing) + ".set"
        shot.store.room(shot.store.object_path(name)).write_text(json.dumps(listing))
        with pytest.raises(LostObject):
            read_listing(shot.store, name)
        with pytest.raises(ValueError, match="not a relative name"):
            check_name(label)


@pytest.mark.parametrize("stem", ["../../shot", "a", "A" * 40, "a" * 40 + "\n", "a" * 39 + "/", ""])
def test_invalid_names_are_not_paths(shot, stem):
    for name in (stem + ".h5", "a" * 40 + ".py"):
        with pytest.raises(ValueError, match="is not an object"):
            shot.store.object_path(name)
    with pytest.raises(ValueError, match="is not a key"):
        shot.store.action_path(stem)


OTHERS = [None, 3, "text", [], {}, {"1": 5, "": ["x"], "2": "../../../shot"}, {"path": 1}, {"companions": []}]


JSON = ("actions/??/*.json", "latest/*/*.json", "notes/??/*", "objects/??/*.set")
"""Files of a store with JSON."""


@pytest.mark.parametrize("turn", [0, 4])
@pytest.mark.slow
def test_json_that_is_not_ours_is_noticed_and_mended(shot, listed, turn):
    """Wherever there is JSON: files of a kind get the others in turn."""
    _, _, right = listed
    for kind in JSON:
        for place, path in enumerate(sorted(shot.store.root.glob(kind)), turn):
            rewrite(path, json.dumps(OTHERS[place % len(OTHERS)]).encode())
    shot.path.with_suffix(".json").write_text("{}")
    assert set(shot.plan(list__parts="true")) == set(shot.plan())
    assert shot.run(list__parts="true").exit_code == 0
    assert published(shot) == right and verify(shot.store, digest_file) == Found()


def test_no_json_that_is_not_ours_is_believed(shot, listed):
    path, record, _ = listed
    (latest,) = shot.store.root.glob("latest/*/list.json")
    note = next(shot.store.root.glob("notes/??/*"))
    for other in OTHERS:
        for damaged in (path, latest, note):
            damaged.touch()
            rewrite(damaged, json.dumps(other).encode())
        with pytest.raises(LostObject):
            files_of(shot.store, record.outputs[""], shot.folder / "elsewhere" / "list.txt")
        assert shot.store.recall(note.name) is None
        assert all(isinstance(key, str) for key in shot.store.latest(shot.load().name, "list").values())


ALLOWED = dict.fromkeys(["seconds", "created"], (3, -1.5)) | dict.fromkeys(["processor", "compiled"], (None, 3, -1.5))
ALLOWED |= dict.fromkeys(["warnings", "prepare_warnings"], ([],)) | {"outputs": ({},), "node": ("text",)}
ALLOWED |= dict.fromkeys(["processor_class", "threading_layer"], (None, "text"))
ALLOWED |= {"frame": (None, 3), "state": (None,)}
"""Values of `OTHERS` that fields of a record may have."""


def test_a_record_of_another_shape_is_none(listed):
    _, record, _ = listed
    whole = asdict(record)
    for name in whole:
        for other in (*OTHERS, -1.5):
            fields = whole | {name: other}
            text = json.dumps(fields, separators=(",", ":"))
            found = read_record(f'{text[:-1]}{MARK}{digest_bytes("record", text.encode())}"}}')
            assert found is None or other in ALLOWED.get(name, ()), (name, other)


@pytest.mark.parametrize("place", ["objects/??/*", "[aln]*/*/*", "objects/??", "actions/??", "*"])
@pytest.mark.slow
def test_wrong_kinds_of_paths_are_removed(shot, listed, place):
    """A folder with something in it where a file should be, a file where a folder should be."""
    _, _, right = listed
    for path in list(shot.store.root.glob(place)):
        if path.is_dir():
            shutil.rmtree(path)
            path.write_text("a file")
        else:
            path.unlink()
            path.mkdir()
            (path / "within").write_text("")
    shutil.rmtree(shot.folder / "out")
    shot.plan(list__parts="true")
    outcome = shot.run(list__parts="true")
    assert outcome.failures == () and published(shot) == right
    assert verify(shot.store, digest_file) == Found()


def test_verify_continues_after_what_it_cannot_read(shot, listed, monkeypatch):
    """It names that, and a folder in place of an object, and what cannot be removed."""
    path, *_ = listed
    objects = sorted(shot.store.root.glob("objects/??/*.h5"))
    objects[2].unlink()
    objects[2].mkdir()
    truncate(objects[3])

    def check(file):
        if file == objects[0]:
            raise PermissionError(errno.EACCES, "Permission denied", str(file))
        if file == objects[1]:
            raise MemoryError
        return digest_file(file)

    found = verify(shot.store, check)
    assert sorted(found.damaged) == [f"objects/{objects[2].name}", f"objects/{objects[3].name}"]
    unread = [f"objects/{objects[0].name}: Permission denied", f"objects/{objects[1].name}: not enough memory"]
    assert sorted(found.unread) == unread
    truncate(path)
    monkeypatch.setattr(Path, "unlink", lambda self, missing_ok=False: None)
    assert verify(shot.store, digest_file).unread == [f"objects/{path.name}: damaged, and cannot be removed"]


def test_verify_finds_a_record_that_lies_about_its_key(shot, listed):
    _, record, _ = listed
    other = replace(record, parts=record.parts | {"settings": {"parts": False}})
    write_text(shot.store.action_path(record.key), write_record(other))
    assert verify(shot.store, digest_file).damaged == [f"actions/{record.key}.json"]


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
def test_unreadable_files_are_not_damaged(tmp_path, request, value):
    store, kind = Store(tmp_path), type(value)
    path = store.object_path(Values(store, 0).put(value, kind, None).object)
    request.getfixturevalue("no_more_files")
    with pytest.raises(OSError, match="Too many open files"):
        Values(store, 0).get(path.name, kind)
    with pytest.raises(OSError, match="Too many open files"):
        is_whole(path, hdf5.digest_file)
    assert path.exists()


def test_store_is_remade_from_nothing_but_a_folder(shot):
    store = Store(shot.folder / "deep" / "new")
    assert shot.run(store=store, to=["seed"]).exit_code == 0
