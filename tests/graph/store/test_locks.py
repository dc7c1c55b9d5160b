"""Locks between processes, by key."""

import os
import subprocess
import sys

import pytest

from hairpipe.graph.store.locks import KeyLocks

ONE, OTHER = "0123456789abcdef" * 2, "fedcba9876543210" * 2
HOLD = """
import sys
from pathlib import Path
from hairpipe.graph.store.locks import KeyLocks
print(KeyLocks(Path(sys.argv[1])).acquire(sys.argv[2]), flush=True)
sys.stdin.read()
"""


def hold(path, key):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, path, key], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    return process, process.stdout.readline().strip() == "True"


def test_a_key_is_held_by_one_process_until_it_ends(tmp_path):
    path = tmp_path / "store" / "lock"
    process, held = hold(path, ONE)
    locks = KeyLocks(path)
    assert held and not locks.acquire(ONE) and locks.acquire(OTHER)
    process.kill()
    process.communicate()
    assert locks.acquire(ONE)
    assert not locks.acquire(ONE), "nor twice by the same process"
    second, held = hold(path, OTHER)
    second.communicate()
    assert not held
    locks.release(OTHER)
    third, held = hold(path, OTHER)
    third.communicate()
    assert held
    locks.close()


def test_a_store_that_may_not_be_written_to_is_an_error_and_nothing_to_wait_for(tmp_path, monkeypatch):
    def refuse(*arguments):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(PermissionError):
        KeyLocks(tmp_path / "lock").acquire(ONE)
