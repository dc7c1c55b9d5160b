"""A folder of nodes is code: nothing of it is imported before it is trusted, nor after it has changed."""

import json
import os
import shutil
import sys

import pytest

from hairpipe.engine.code import CodeReader
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.file.trust import (
    Untrusted,
    code_in,
    register,
    revoke,
    shipped_folders,
    trust,
    trust_error,
    trusted,
)
from hairpipe.engine.node.messages import listed
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.errors import BadInput

MARK = "open({!r}, 'a').write('imported')\n"


@pytest.fixture(autouse=True)
def nobody(tmp_path, monkeypatch):
    """A user who has trusted nothing yet."""
    monkeypatch.delenv("HAIRPIPE_TRUST", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


@pytest.fixture
def marked(shot):
    """The shot, whose nodes leave a mark when they are imported."""
    for path in shot.nodes.glob("*.py"):
        path.write_text(path.read_text() + MARK.format(str(shot.folder / "mark")))
    return shot


def test_nothing_is_imported_before_it_is_trusted(marked):
    with pytest.raises(Untrusted) as caught:
        marked.load()
    files = listed(list(code_in(marked.nodes)))
    right = f"hairpipe trust {marked.nodes}, after reading the code"
    assert str(caught.value) == f"{marked.nodes}: the code is not trusted: {files} ({right})"
    assert files.startswith("add_up.py, draw_number.py, ")
    assert str(marked.nodes) not in sys.path and not (marked.folder / "mark").exists()


def test_trusted_code_runs_and_changed_code_is_named(marked):
    trust(marked.nodes, code_in(marked.nodes))
    assert not marked.run(frames=[1]).failures
    marked.edit("tally.py", "import", "import sys, ")
    (marked.nodes / "new.py").write_text("")
    with pytest.raises(Untrusted, match=r"the code has changed since it was trusted: new\.py, tally\.py \("):
        marked.load()


def test_code_changed_after_reading_is_not_run(marked):
    """The graph was loaded, and no worker has imported anything yet."""
    trust(marked.nodes, code_in(marked.nodes))
    graph = marked.load()
    (marked.folder / "mark").unlink()
    (marked.nodes / "make_seed.py").write_text("1 / 0")
    (failure,) = run(graph, marked.store, options=Options(jobs=1)).failures
    assert "the code has changed since it was trusted: make_seed.py" in failure.message
    assert not (marked.folder / "mark").exists()


def test_only_importable_files_are_part_of_trust(shot, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "inner.py").write_text("")
    (shot.nodes / "tools").symlink_to(elsewhere)
    (shot.nodes / "round").symlink_to(shot.nodes)
    before = code_in(shot.nodes)
    assert "tools/inner.py" in before
    (shot.nodes / "table.json").write_text("{}")
    (shot.nodes / ".git").mkdir()
    (shot.nodes / ".git" / "hook.py").write_text("")
    (shot.nodes / "__pycache__").mkdir()
    (shot.nodes / "__pycache__" / "add_up.cpython-311.pyc").write_bytes(b"")
    assert code_in(shot.nodes) == before
    (elsewhere / "inner.py").write_text("1")
    (shot.nodes / "fast.so").write_bytes(b"")
    (shot.nodes / "libfast.so.1").write_bytes(b"")
    (shot.nodes / "old.pyc").write_bytes(b"")
    (shot.nodes / "__pycache__" / "odd.py").write_bytes(b"")
    after = code_in(shot.nodes)
    changed = {name for name in after if after[name] != before.get(name)}
    assert changed == {"tools/inner.py", "fast.so", "libfast.so.1", "old.pyc", "__pycache__/odd.py"}


def test_copies_are_trusted_together(shot):
    trust(shot.nodes, code_in(shot.nodes))
    copy = shot.folder / "other" / "nodes"
    shutil.copytree(shot.nodes, copy)
    assert trust_error(copy) is None
    assert revoke(copy) and trust_error(shot.nodes) and not revoke(copy)


def test_a_graph_that_needs_nothing_of_a_folder_does_without(marked):
    marked.path.write_text('schema = 1\nframes = [1, 1]\nfps = 24\n[head]\ntype = "make_bust"\n')
    graph = load_graph(marked.path)
    assert CodeReader(lambda name, make: make(), marked.nodes).code_of(graph.nodes["head"].type.module).parts
    assert str(marked.nodes) not in sys.path and not (marked.folder / "mark").exists()
    shutil.copy(marked.nodes / "make_seed.py", marked.nodes / "make_bust.py")  # and never gets another one of the name
    with pytest.raises(Untrusted):
        load_graph(marked.path)


def test_folders_that_the_environment_names_are_trusted(shot, monkeypatch):
    monkeypatch.setenv("HAIRPIPE_TRUST", os.pathsep.join(["", "nodes", str(shot.folder / "other")]))
    monkeypatch.chdir(shot.folder)
    assert trust_error(shot.nodes), "a relative path names whatever folder one is in"
    monkeypatch.setenv("HAIRPIPE_TRUST", os.pathsep.join(["/none", str(shot.nodes)]))
    assert trust_error(shot.nodes) is None


def test_our_own_nodes_need_nothing():
    assert all(trust_error(folder) is None for folder in shipped_folders())
    assert {folder.parent.name for folder in shipped_folders()} >= {"experiments"}


@pytest.mark.parametrize("which", ["folder", "file", "link"])
def test_records_writable_by_others_are_ignored(shot, which):
    trust(shot.nodes, code_in(shot.nodes))
    (path,) = register().glob("*.json")
    if which == "link":
        register().rename(register().with_name("real"))
        register().symlink_to(register().with_name("real"))
    else:
        (register() if which == "folder" else path).chmod(0o777)
    assert not list(trusted())
    assert "is not trusted" in str(trust_error(shot.nodes))
    if which == "folder":
        assert f"{register()} can be written to by others" in str(trust_error(shot.nodes))
        with pytest.raises(BadInput, match="chmod"):
            trust(shot.nodes, code_in(shot.nodes))


def test_records_of_other_users_are_ignored(shot, monkeypatch):
    trust(shot.nodes, code_in(shot.nodes))
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    assert not list(trusted()) and "belongs to somebody else" in str(trust_error(shot.nodes))


def test_a_damaged_entry_is_none(shot):
    trust(shot.nodes, code_in(shot.nodes))
    (path,) = register().glob("*.json")
    for text in ("", "[1]", "null", json.dumps({"folder": 3, "files": {}}), json.dumps({"folder": "/", "files": 3})):
        path.write_text(text)
        assert trust_error(shot.nodes)


def test_without_a_home_nothing_is_trusted(shot, monkeypatch):
    monkeypatch.delenv("XDG_CONFIG_HOME")
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)
    assert "no folder for the list of trusted code" in str(trust_error(shot.nodes))
    with pytest.raises(OSError, match="no home folder"):
        trust(shot.nodes, code_in(shot.nodes))
