"""A store of several users, who belong to one group or may only read; by forks that become other users, so by root."""

import os
import shutil
import tempfile
import traceback
from functools import partial
from pathlib import Path

import pytest

from hairpipe.engine.plan.maintenance import clean
from hairpipe.engine.store.atomic import replacing, workspace
from hairpipe.engine.store.lease import Leases
from hairpipe.engine.store.ownership import check_store
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput

from .conftest import Shot

ONE, OTHER, READER, GROUP = 54321, 54322, 54323, 54399
KEYS = ["0123456789abcdef0123" * 2, "fedcba9876543210fedc" * 2]

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="needs several users")


@pytest.fixture
def place():
    """A folder that all users can reach."""
    folder = Path(tempfile.mkdtemp(dir="/tmp"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.fixture
def store(place):
    """An empty store whose folder belongs to a user and a group."""
    root = place / "store"
    root.mkdir()
    os.chown(root, ONE, GROUP)
    root.chmod(0o775)
    write_everything(Store(place / "own"), KEYS[0], 0)  # the interpreter, which loads late, may be out of their reach
    return Store(root)


def outcome_of(function):
    """Call a function; returns its text, its message where the input was bad, or the traceback of a defect."""
    try:
        return str(function())
    except BadInput as fault:
        return str(fault)
    except Exception:
        return traceback.format_exc()


def as_user(user, function, *, groups=(GROUP,), umask=0o077):
    """Call a function as another user; returns its text, or a traceback."""

    def call():
        os.setgroups(groups)
        os.setgid(user)
        os.setuid(user)
        os.umask(umask)
        return function()

    read, write = os.pipe()
    child = os.fork()
    if not child:
        try:
            os.write(write, outcome_of(call).encode()[:60000])
        finally:  # a child never goes on with the tests
            os._exit(0)
    os.close(write)
    with os.fdopen(read) as file:
        text = file.read()
    os.waitpid(child, 0)
    return text


def write_everything(store, key, number):
    """Write one of everything that a run writes."""
    check_store(store.root)
    leases = Leases(store)
    assert leases.acquire(key)
    with workspace(store.temporary) as folder:
        (folder / "half").write_text("")
    name = f"{key}.bin"
    with replacing(store.room(store.object_path(name)), store.temporary) as path:
        path.write_text("bytes")
        path.chmod(0o444)
    store.note(key, f"note {number}")
    store.set_latest("graph", "node", {str(number): key})
    leases.release(key)
    return "written"


@pytest.mark.parametrize("umask", [0o077, 0o022])
def test_members_of_a_group_write_to_one_store_for_any_umask(store, umask):
    def live():
        return clean(store, older=0.0).objects, store.sweep()

    def read(key, number):
        return store.recall(key), store.latest("graph", "node")[str(number)]

    for user in (ONE, OTHER, ONE):
        for number, key in enumerate(KEYS):
            assert as_user(user, partial(write_everything, store, key, number), umask=umask) == "written"
            assert as_user(OTHER, partial(read, key, number)) == str((f"note {number}", key))
    for path in store.root.rglob("*"):
        status = path.stat()
        assert status.st_gid == GROUP, path
        allowed = 0o2775 if path.is_dir() else 0o444 if path.suffix == ".bin" else 0o660 | 0o666 & ~umask
        assert status.st_mode & 0o7777 == allowed, path
    assert as_user(OTHER, live) == "(0, 0)", "results are young"
    assert as_user(READER, lambda: write_everything(store, KEYS[0], 0), groups=()).startswith(
        f"{store.root}: a store of"
    )


def test_files_of_killed_processes_of_other_users_are_swept(store):
    def be_killed():
        with workspace(store.temporary) as folder:
            (folder / "half").write_text("")
            Leases(store).acquire(KEYS[0])
            os._exit(1)

    store.room(store.temporary / "any")
    assert as_user(ONE, be_killed) == ""
    assert len(list(store.temporary.iterdir())) == 2
    assert as_user(OTHER, lambda: (store.sweep(), Leases(store).acquire(KEYS[0]))) == "(1, True)"
    assert list(store.temporary.iterdir()) == []


def test_a_user_who_may_only_read_gets_what_is_there_and_one_line(shot, place, monkeypatch):
    public = Shot(place / "shot")
    public.change('publish = "out/list.txt"\n', "")
    monkeypatch.setenv("HAIRPIPE_TRUST", str(public.nodes))
    public.run()
    for path in [public.store.root, *public.store.root.rglob("*")]:
        os.chown(path, ONE, GROUP)
    monkeypatch.setenv("HOME", str(place))
    before = sorted(public.store.root.rglob("*"))
    assert as_user(READER, lambda: public.run().cached, groups=()) == "22"
    message = as_user(READER, lambda: public.run(seed__value=7), groups=())
    assert message.startswith(f"{public.store.root}: 'seed' has to be computed, and the store cannot be written to")
    assert "--cache FOLDER of your own" in message
    assert sorted(public.store.root.rglob("*")) == before
