"""Files that appear whole or not at all."""

import errno
import fcntl
import os
import secrets
import subprocess
import sys

import pytest

from hairpipe.graph.store.atomic import is_left_over, making, open_made, replacing, sweep, write_text


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "a"
    write_text(path, "old")
    with pytest.raises(OSError, match="disk"), replacing(path) as temporary:
        temporary.write_text("half")
        raise OSError("disk")
    assert path.read_text() == "old" and names_in(tmp_path) == ["a"]


def hold(folder):
    """Start a process that has a file and a workspace in the making there, until its input ends."""
    code = """
import sys
from pathlib import Path
from hairpipe.graph.store.atomic import making, workspace
with making(Path(sys.argv[1])), workspace(Path(sys.argv[1])) as folder:
    (folder / "half").write_text("")
    print(flush=True)
    sys.stdin.read()
"""
    holder = subprocess.Popen([sys.executable, "-c", code, folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    holder.stdout.readline()
    return holder


def test_sweep_takes_what_the_dead_left_and_spares_the_living(tmp_path):
    """Of whom it knows neither number nor machine: a lock is held, or it is not."""
    holder = hold(tmp_path)
    there = names_in(tmp_path)
    assert len(there) == 3 and sweep(tmp_path) == sweep(tmp_path, ours_alone=True) == 0
    assert names_in(tmp_path) == there
    holder.kill()
    holder.wait()
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
    assert is_left_over(path), "it has let go, and the fork never held it"
    os.close(write)
    os.waitpid(child, 0)
    os.close(read)


def test_names_are_random_and_what_stands_there_is_not_followed(tmp_path, monkeypatch):
    victim = tmp_path / "victim"
    victim.write_text("mine")
    names = iter("a" * 32 for _ in range(2))
    monkeypatch.setattr(secrets, "token_hex", lambda size: next(names, "b" * 2 * size))
    (tmp_path / f".hairpipe-{'a' * 32}.tmp").symlink_to(victim)
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
    names = ["other", "notes.tmp", "render-7-2.tmp", ".hairpipe-x.tmp", f".hairpipe-{'c' * 31}.tmp"]
    for name in names:
        (tmp_path / name).write_text("")
        os.utime(tmp_path / name, (0, 0))  # however old, they are somebody else's
    (tmp_path / f".hairpipe-{'d' * 32}.tmp").symlink_to(tmp_path / "other")
    there = names_in(tmp_path)
    assert sweep(tmp_path, ours_alone=True) == 0 and names_in(tmp_path) == there


def test_what_no_lock_tells_of_goes_by_its_age_where_nobody_else_writes(tmp_path, monkeypatch):
    """Of older versions, and of file systems without locks."""
    monkeypatch.setattr(fcntl, "flock", without_locks)
    for number, name in enumerate([".hairpipe-elsewhere-1-{}.tmp", ".hairpipe-" + "e" * 31 + "{}.tmp"]):
        for age in (0, 1):
            path = tmp_path / name.format(age)
            path.mkdir() if number == 0 else path.write_text("")
            os.utime(path, None if age == 0 else (0, 0))
    assert sweep(tmp_path) == 0 and sweep(tmp_path, ours_alone=True) == 2
    assert [name[-5] for name in names_in(tmp_path)] == ["0", "0"]
    write_text(tmp_path / "file", "text")
    assert (tmp_path / "file").read_text() == "text"


def without_locks(handle, operation):
    raise OSError(errno.ENOLCK, "No locks available")
