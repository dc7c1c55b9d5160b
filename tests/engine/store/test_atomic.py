"""Files that appear whole or not at all."""

import os
import subprocess
import sys
import time

import pytest

from hairpipe.engine.store import atomic, holder
from hairpipe.engine.store import holder as renewal
from hairpipe.engine.store.atomic import is_left_over, making, open_made, replacing, sweep, workspace, write_text
from tests.engine.conftest import wait_for


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "a"
    write_text(path, "old")
    with pytest.raises(OSError, match="disk"), replacing(path) as temporary:
        temporary.write_text("half")
        raise OSError("disk")
    assert path.read_text() == "old" and names_in(tmp_path) == ["a"]


def test_a_file_whose_folder_has_gone_meanwhile_is_there_in_the_end(tmp_path):
    path = tmp_path / "new" / "a"
    path.parent.mkdir()
    with replacing(path, tmp_path) as temporary:
        temporary.write_text("whole")
        path.parent.rmdir()
    assert path.read_text() == "whole"


def hold(folder):
    """Start a process that has a file and a workspace in the making there, until its input ends."""
    code = """
import sys
from pathlib import Path
from hairpipe.engine.store.atomic import making, workspace
with making(Path(sys.argv[1])), workspace(Path(sys.argv[1])) as folder:
    (folder / "half").write_text("")
    print(flush=True)
    sys.stdin.read()
"""
    process = subprocess.Popen([sys.executable, "-c", code, folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    process.stdout.readline()
    return process


def test_sweep_takes_what_the_dead_left_and_spares_the_living(tmp_path):
    """Processes of this machine are looked up."""
    living = hold(tmp_path)
    there = names_in(tmp_path)
    assert len(there) == 3 and sweep(tmp_path) == 0
    assert names_in(tmp_path) == there
    living.kill()
    living.wait()
    assert sweep(tmp_path) == 2 and names_in(tmp_path) == []
    assert sweep(tmp_path / "missing") == 0


def test_a_process_that_died_and_was_not_collected_is_dead(tmp_path):
    zombie = hold(tmp_path)
    zombie.kill()
    os.waitid(os.P_PID, zombie.pid, os.WEXITED | os.WNOWAIT)
    assert sweep(tmp_path) == 2
    zombie.communicate()


def test_a_fork_does_not_hold_what_its_parent_has_in_the_making(tmp_path):
    read, write = os.pipe()
    with making(tmp_path) as (path, _):
        child = os.fork()
        if not child:
            os.close(write)
            os.read(read, 1)
            os._exit(0)
        assert not is_left_over(path), "the parent lives"
    path.touch()
    assert not is_left_over(path), "this process may still be about to use it"
    forked = path.with_name(path.name.replace(f"-{os.getpid()}-", f"-{child}-"))
    forked.touch()
    assert is_left_over(forked), "its number belonged to another process, which began at another time"
    os.close(write)
    os.waitpid(child, 0)
    os.close(read)


def test_names_are_random_and_what_stands_there_is_not_followed(tmp_path, monkeypatch):
    victim = tmp_path / "victim"
    victim.write_text("mine")
    monkeypatch.setattr(atomic, "make_name", lambda: "a")
    (tmp_path / ".hairpipe-a.tmp").symlink_to(victim)
    with pytest.raises(FileExistsError):
        write_text(tmp_path / "file", "text")
    assert victim.read_text() == "mine" and not (tmp_path / "file").exists()


def test_a_link_put_in_place_of_what_is_in_the_making_is_not_followed(tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("mine")
    with pytest.raises(OSError, match="replaced the file"), replacing(tmp_path / "file") as temporary:
        temporary.unlink()
        temporary.symlink_to(victim)
        with pytest.raises(OSError, match="symbolic link"):
            open_made(temporary)
    assert names_in(tmp_path) == ["victim"] and victim.read_text() == "mine"


def test_sweep_leaves_what_is_not_ours(tmp_path):
    names = ["other", "notes.tmp", "render-7-2.tmp", "x.hairpipe-x.tmp"]
    for name in names:
        (tmp_path / name).write_text("")
        os.utime(tmp_path / name, (0, 0))  # however old, they are somebody else's
    (tmp_path / f".hairpipe-{'d' * 32}.tmp").symlink_to(tmp_path / "other")
    there = names_in(tmp_path)
    assert sweep(tmp_path) == 0 and names_in(tmp_path) == there


def test_files_of_other_machines_go_a_day_after_they_were_last_renewed(tmp_path, monkeypatch):
    """By the clock of the file system: that of this machine may be off by years."""
    monkeypatch.setattr(time, "time", lambda: 0.0)
    now = time.clock_gettime(time.CLOCK_REALTIME)
    for hours in (-3, 0, 23, 25):
        with monkeypatch.context() as elsewhere:
            elsewhere.setattr(holder, "machine", lambda: "0123456789ab")
            path = tmp_path / f".hairpipe-{holder.make_name()}.tmp"
        path.write_text(str(hours))
        os.utime(path, (now - hours * 3600,) * 2)
    assert sweep(tmp_path) == 1
    assert sorted(path.read_text() for path in tmp_path.iterdir()) == ["-3", "0", "23"]


def test_a_file_in_the_making_is_renewed_again_and_again(tmp_path, monkeypatch):
    with making(tmp_path) as (path, _):
        os.utime(path, (0, 0))
        renewal.renewal.renew()
        assert path.stat().st_mtime > 0
    monkeypatch.setattr(renewal, "PERIOD", 0.01)
    file, thread = tmp_path / "file", renewal.Renewal()
    with file.open("w") as held:
        thread.add(held.fileno())
        for _ in range(3):
            os.utime(file, (0, 0))
            wait_for(lambda: file.stat().st_mtime > 0)
        thread.discard(held.fileno())


@pytest.mark.parametrize("mode", [0o2775, 0o755])
def test_in_a_folder_of_a_group_its_members_may_write(tmp_path, mode):
    folder = tmp_path / "folder"
    folder.mkdir()
    folder.chmod(mode)
    before = os.umask(0o077)
    try:
        with workspace(folder) as work:
            assert work.stat().st_mode & 0o7777 == (0o2775 if mode == 0o2775 else 0o700)
            with making(folder) as (path, _):
                assert path.stat().st_mode & 0o7777 == (0o660 if mode == 0o2775 else 0o600)
    finally:
        os.umask(before)


def test_a_folder_is_discarded_with_what_is_in_it_and_of_a_link_the_link_alone(tmp_path):
    kept, gone = tmp_path / "kept", tmp_path / "gone"
    for folder in (kept, gone):
        folder.mkdir()
        (folder / "a").touch()
    (tmp_path / "link").symlink_to(kept)
    for name in ("gone", "link", "absent"):
        atomic.discard(tmp_path / name)
    assert names_in(tmp_path) == ["kept"] and names_in(kept) == ["a"]
