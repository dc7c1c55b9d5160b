"""Files that appear whole or not at all."""

import os
import subprocess
import sys

import pytest

from hairpipe.graph.atomic import HOST, replacing, sweep, write_text


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "a"
    write_text(path, "old")
    with pytest.raises(OSError, match="disk"), replacing(path) as temporary:
        temporary.write_text("half")
        raise OSError("disk")
    assert path.read_text() == "old" and names_in(tmp_path) == ["a"]


def test_sweep_takes_what_the_dead_left_and_spares_the_living(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    names = {
        f".hairpipe-{HOST}-{dead.pid}-0.tmp": False,
        f".hairpipe-{HOST}-{os.getpid()}-0.tmp": True,
        ".hairpipe-elsewhere-1-0.tmp": True,
        f".hairpipe-{HOST}-x-0.tmp": True,
        "other": True,
        "notes.tmp": True,
        "render-7-2.tmp": True,
    }
    for name in names:
        (tmp_path / name).write_text("")
    for name in ("notes.tmp", "render-7-2.tmp"):
        os.utime(tmp_path / name, (0, 0))  # however old, they are somebody else's
    (tmp_path / f".hairpipe-{HOST}-{dead.pid}-1.tmp").mkdir()
    old = tmp_path / ".hairpipe-elsewhere-2-0.tmp"
    old.write_text("")
    os.utime(old, (0, 0))
    assert sweep(tmp_path) == 2, "a process of another machine may run as long as it likes"
    assert sweep(tmp_path, ours_alone=True) == 1
    assert names_in(tmp_path) == sorted(name for name, stays in names.items() if stays)
    assert sweep(tmp_path / "missing") == 0


def test_a_process_that_died_and_was_not_collected_is_dead(tmp_path):
    zombie = subprocess.Popen([sys.executable, "-c", ""], stdout=subprocess.PIPE)
    zombie.stdout.read()  # it has ended; nobody has asked for its exit code
    os.waitid(os.P_PID, zombie.pid, os.WEXITED | os.WNOWAIT)
    (tmp_path / f".hairpipe-{HOST}-{zombie.pid}-0.tmp").write_text("")
    assert sweep(tmp_path) == 1
    zombie.wait()
