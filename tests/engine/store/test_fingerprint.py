"""Digests of files: each file is read once, for as long as its stamp proves its bytes."""

import pytest

from hairpipe.engine.store import fingerprint as module
from hairpipe.engine.store.fingerprint import digest_file, fingerprint
from hairpipe.engine.store.store import Store


@pytest.fixture
def read(monkeypatch):
    """List the files that are digested; any stamp counts as settled."""
    found = []
    monkeypatch.setattr(module, "SETTLED", -(10**18))
    monkeypatch.setattr(module, "digest_file", lambda path: found.append(path.name) or digest_file(path))
    return found


def test_a_file_is_read_once_until_it_changes(tmp_path, read, monkeypatch):
    store, path = Store(tmp_path / "store"), tmp_path / "clip"
    path.write_bytes(b"abc")
    assert [fingerprint(path, store) for _ in range(3)] == 3 * [digest_file(path)] and read == ["clip"]
    path.write_bytes(b"longer")
    assert fingerprint(path, store) == digest_file(path) and read == ["clip", "clip"]
    monkeypatch.setattr(module, "SETTLED", 10**18)
    assert len({fingerprint(path, store) for _ in range(2)}) == 1 and len(read) == 4, "it may have just been written"
