"""Processes by name: of this machine they have ended or not, of others nothing is known."""

import os
import subprocess
import sys

from hairpipe.engine.store import holder
from hairpipe.engine.store.holder import FORM, has_ended, make_name, start_of


def test_this_process_has_not_ended_and_names_are_unique():
    names = {make_name() for _ in range(100)}
    assert len(names) == 100 and all(map(FORM.fullmatch, names)) and not any(map(has_ended, names))


def test_a_process_that_ended_is_known_though_its_number_is_used_again():
    process = subprocess.Popen([sys.executable, "-c", "pass"])
    process.wait()
    machine, pid, start, rest = make_name().split("-")
    assert has_ended(f"{machine}-{process.pid}-{start}-{rest}")
    assert has_ended(f"{machine}-{pid}-{int(start) - 1}-{rest}"), "another process of this number"


def test_nothing_is_known_of_another_machine_and_of_other_names(monkeypatch):
    machine, _, start, rest = make_name().split("-")
    for name in (f"{'f' * 12}-999999999-{start}-{rest}", f"{machine}-x-{start}-{rest}", "", "other"):
        assert not has_ended(name)
    name = make_name()
    monkeypatch.setattr(holder, "start_of", lambda pid: None)
    assert not has_ended(name), "its start is hidden from this user"


def test_a_fork_has_a_name_of_its_own():
    before = make_name()
    read, write = os.pipe()
    child = os.fork()
    if not child:
        os.write(write, make_name().encode())
        os._exit(0)
    os.waitpid(child, 0)
    found = os.read(read, 200).decode()
    os.close(read)
    os.close(write)
    assert FORM.fullmatch(found)[2] != FORM.fullmatch(before)[2] and has_ended(found)
    assert start_of(1) is None or start_of(1).isdigit()


def test_a_machine_has_another_name_after_each_boot(monkeypatch):
    names = []
    for boot in ("one", "other", "one"):
        monkeypatch.setattr(holder.Path, "read_text", lambda path, boot=boot, **how: boot)
        names.append(holder.machine.__wrapped__())
    assert names[0] == names[2] != names[1]
