"""`hairpipe watch`: what exists, what is computed now and where, and that nothing is written."""

import json
import os
import pty
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from hairpipe import load
from hairpipe.app.cli.commands import results as watch
from hairpipe.engine.store.holder import machine
from tests.app.cli.conftest import SHOT, START

ELSEWHERE = "0123456789ab-7-7-0123456789abcdef"
"""Name of a holder on another machine, whose processes cannot be looked up here."""
KINDS = ("computed", "computing", "missing", "waiting")
STORED = {"seed": 1, "move": 6, "sum": 6, "list": 1, "drawing": 6}
FLAKY = '''"""A node that fails until a file is there."""

from pathlib import Path

from numeral import Numeral

from hairpipe.engine import node


@node(frames="once")
def flaky(number: Numeral) -> Numeral:
    """Fail where there is no file."""
    if not Path("ready").exists():
        raise ValueError("not\\nready")
    return number
'''
WEDGE = '\n[wedge.turns]\naxes = { "move.turn" = [1000, 4] }\n'


def state_of(hairpipe, arguments: str = "", code: int = 1) -> dict:
    result = hairpipe(f"watch shot.toml --once --json {arguments}")
    assert result.exit_code == code
    return json.loads(result.stdout)


def counts(state: dict) -> dict[str, tuple[int, ...]]:
    return {name: tuple(node[kind] for kind in KINDS) for name, node in state["nodes"].items()}


def lease(name: str, holder: str, host: str) -> None:
    """Write a lease file as its holder does."""
    Path("cache/lease").mkdir(exist_ok=True)
    Path("cache/lease", name).write_text(json.dumps({"holder": holder, "host": host}))


def files() -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in Path("cache").rglob("*")}


@pytest.fixture
def half(shot, hairpipe) -> dict[str, str]:
    """A shot of whose frames 1 to 3 are computed; the keys of the tasks that can be computed next."""
    assert hairpipe("run shot.toml -j1 -q --only 1-3").exit_code == 0
    return {str(entry.task): entry.key for entry in load(shot, cache="cache").plan() if entry.key is not None}


def test_before_the_first_run_nothing_is_there(shot, hairpipe):
    state = state_of(hairpipe)
    expected = {name: (0, 0, 0, total) for name, total in STORED.items()}
    assert counts(state) == expected | {"seed": (0, 0, 1, 0)}
    assert state["computing"] == [] and state["seconds_left"] is None and not state["complete"]
    assert not Path("cache").exists()


def test_half_way_it_counts_what_is_there_and_writes_nothing(half, hairpipe):
    before = files()
    for path in before:
        path.chmod(path.stat().st_mode & ~0o222)
    state = state_of(hairpipe)
    expected = {"seed": (1, 0, 0, 0), "move": (3, 0, 3, 0), "sum": (3, 0, 0, 3), "list": (0, 0, 0, 1)}
    assert counts(state) == expected | {"drawing": (3, 0, 0, 3)}
    assert files() == before
    assert counts(state_of(hairpipe, "--frames 1-3 --to sum", 0)) == {
        "seed": (1, 0, 0, 0), "move": (3, 0, 0, 0), "sum": (3, 0, 0, 0)
    }  # fmt: skip


def test_a_lease_names_the_machine_that_computes_until_its_process_ends(half, hairpipe):
    lease(half["move@5"], ELSEWHERE, "render-7\x1b[2J")
    state = state_of(hairpipe)
    assert state["computing"] == [{"node": "move", "frame": 5, "host": "render-7\x1b[2J"}]
    move = state["nodes"]["move"]
    assert counts(state)["move"] == (3, 1, 2, 0)
    assert move["seconds_left"] == pytest.approx(3 * move["seconds_each"]) and move["seconds_each"] > 0.0
    line = next(line for line in hairpipe("watch shot.toml --once").stdout.splitlines() if line.startswith("move: "))
    assert line.endswith("; computing: render-7\\x1b[2J 1; 2 missing") and line.startswith("move: 3/6, ")
    lease(f"{half['move@5']}.{ELSEWHERE}", ELSEWHERE.replace("-7-7-", "-8-8-"), "second")
    assert [task["host"] for task in state_of(hairpipe)["computing"]] == ["second"], "the successor of a lease"
    Path("cache/lease", f"{half['move@5']}.{ELSEWHERE}").unlink()
    process = subprocess.Popen(["true"])
    lease(half["move@5"], f"{machine()}-{process.pid}-1-0123456789abcdef", "here")
    process.wait()
    assert counts(state_of(hairpipe))["move"] == (3, 0, 3, 0), "the process has ended"


def test_a_failure_is_reported_until_the_next_start(shot, hairpipe):
    shot.write_text(f'{SHOT}[flaky]\ntype = "flaky"\nin.number = "seed"\n')
    Path("nodes/flaky.py").write_text(FLAKY)
    assert hairpipe("run shot.toml -j1 -q --to flaky").exit_code == 1
    failed = f"failed on {socket.gethostname()}: ValueError: not\\nready"
    state = state_of(hairpipe, "--to flaky")
    failure = {"node": "flaky", "frame": None, "host": socket.gethostname(), "message": "ValueError: not\nready"}
    assert state["failed"] == [failure]
    assert (state["nodes"]["flaky"]["failed"], state["nodes"]["flaky"]["missing"]) == (1, 0)
    assert f"flaky: 0/1; 1 {failed}\n" in hairpipe("watch shot.toml --once").stdout
    assert f"will run: {failed}\n" in hairpipe("plan shot.toml --missing").stdout
    lease(next(e.key for e in load(shot, cache="cache").plan() if e.task.node == "flaky"), ELSEWHERE, "render-7")
    assert state_of(hairpipe, "--to flaky")["failed"] == [] and len(state_of(hairpipe)["computing"]) == 1
    for path in Path("cache/lease").iterdir():
        path.unlink()
    Path("ready").touch()
    notes = sorted(Path("cache/notes").glob("??/*"))
    assert hairpipe("run shot.toml -j1 -q --to flaky").exit_code == 0
    assert state_of(hairpipe, "--to flaky", 0)["failed"] == []
    assert len(notes) == 1 + len(list(Path("cache/notes").glob("??/*")))


def test_lines_follow_a_run_until_all_is_there(half, hairpipe, monkeypatch):
    """Between two reads of the cache the rest is run, up to the sum and then all."""
    rest = iter(["--to sum", ""])
    lease(half["move@5"], ELSEWHERE, "render-7")

    def run(seconds: float) -> None:
        for path in Path("cache/lease").iterdir():
            path.unlink()
        assert hairpipe(f"run shot.toml -j1 -q {next(rest)}").exit_code == 0

    monkeypatch.setattr(watch, "time", SimpleNamespace(sleep=run))
    result = hairpipe("watch shot.toml")
    assert result.exit_code == 0 and "\x1b" not in result.stdout
    lines = [line.partition(", 0.")[0] for line in result.stdout.splitlines()]
    between = ["move: 6/6", "sum: 6/6", "list: 0/1; 1 missing", "drawing: 3/6; 3 missing"]
    between += ["16 of 20 results, none being computed"]
    assert lines[-8:] == [*between, "list: 1/1", "drawing: 6/6", "20 of 20 results"]


def test_a_complete_shot_is_exit_code_0_and_variants_are_counted_together(computed, hairpipe):
    state = state_of(hairpipe, code=0)
    assert state["complete"] and counts(state) == {name: (total, 0, 0, 0) for name, total in STORED.items()}
    assert hairpipe("watch shot.toml").stdout.splitlines()[-1] == "20 of 20 results"
    assert state_of(hairpipe, "--set move.turn=4")["nodes"]["move"]["missing"] == 6
    computed.write_text(SHOT + WEDGE)
    assert counts(state_of(hairpipe, "--wedge turns"))["sum"] == (6, 0, 0, 6)


def test_a_terminal_gets_a_table(computed):
    process, terminal = pty.fork()
    if process == 0:
        os.execv(sys.executable, [*START, "watch", "shot.toml"])
    output = b""
    try:
        while data := os.read(terminal, 4096):
            output += data
    except OSError:  # the other end is gone
        pass
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 0
    text = output.decode()
    assert "drawing" in text and "━" in text and "20 of 20 results" in text
