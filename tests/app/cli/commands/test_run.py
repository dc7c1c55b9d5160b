"""`hairpipe run`: what it computes, prints and returns."""

import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hairpipe.app.api import source

from ..conftest import START


def test_the_first_run_computes_and_the_second_finds(shot, hairpipe):
    first = hairpipe("run shot.toml -j1")
    assert first.exit_code == 0 and first.stdout.startswith("node     computed  cached  seconds  processor\n")
    assert "20 results computed, 0 cached" in first.stdout
    lines = first.stdout.splitlines()
    assert {"list     out/list.txt", "drawing  out/drawing.0001.txt ... drawing.0006.txt (6 files)"} <= set(lines)
    assert Path("out/drawing.0006.txt").is_file()
    second = hairpipe("run shot.toml -j1")
    assert "0 results computed, 20 cached" in second.stdout
    assert "sum: cached" in second.stderr


def test_frames_and_nodes_are_selected(shot, hairpipe):
    document = json.loads(hairpipe("run shot.toml -j1 --json --frames 1-4x3 --to sum").stdout)
    assert document["frames"] == [1, 4]
    assert {name: node["total"] for name, node in document["nodes"].items()} == {"seed": 1, "move": 4, "sum": 4}
    assert document["published"] == []


def test_waiting_and_working_are_distinguished(shot, hairpipe):
    path = Path("nodes") / "make_seed.py"
    path.write_text(path.read_text().replace("    tally(", "    import time\n\n    time.sleep(0.5)\n    tally("))
    seed = json.loads(hairpipe("run shot.toml -j1 --json --to seed").stdout)["nodes"]["seed"]
    assert seed["seconds"] >= 0.5 and 0.0 <= seed["processor"] < 0.3


def test_settings_are_set_for_once(computed, hairpipe):
    assert "0 results computed" in hairpipe("run shot.toml -j1 --set seed.value=3").stdout
    document = json.loads(hairpipe("run shot.toml -j1 --json --set seed.value=4 --set seed.value=5.0").stdout)
    assert document["evaluated"] == 20
    assert json.loads(hairpipe("run shot.toml -j1 --json").stdout)["evaluated"] == 0


def test_the_document_is_all_that_goes_to_the_output(failing, hairpipe):
    result = hairpipe("run shot.toml -j1 --json -k --set sum.warn=2")
    document = json.loads(result.stdout)
    assert result.exit_code == document["exit_code"] == 1
    (failure,) = document["failures"]
    assert (failure["node"], failure["frame"], failure["kind"]) == ("bad", 3, "node")
    assert document["warnings"] == [{"node": "sum", "frames": [2], "message": "a strand is too short"}]
    assert len(document["published"]) == 7 and all(Path(path).is_file() for path in document["published"])


def test_a_failure_names_node_and_frame_and_the_traceback_on_request(failing, hairpipe):
    result = hairpipe("run shot.toml -j1 -k")
    assert result.exit_code == 1 and Path("out/list.txt").is_file(), "which does not depend on the failure"
    assert "failed: bad@3: ZeroDivisionError: no strands left" in result.stderr
    assert result.stderr.splitlines()[-1] == "hairpipe: bad@3 failed; -v shows where in the code"
    assert "Traceback" not in result.stderr + result.stdout
    assert "Traceback" in hairpipe("run shot.toml -j1 -v").stderr
    result = hairpipe("run shot.toml -j1 --set bad.how=input")
    assert result.exit_code == 2 and "failed: bad@3: walk.bvh:7: not a clip" in result.stderr


def test_quiet_says_only_what_matters(failing, hairpipe):
    result = hairpipe("run shot.toml -j1 -q --to sum --set sum.warn=2")
    assert (result.stdout, result.stderr) == ("", "warning: sum@2: a strand is too short\n")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("shot.toml --frames 0-3", "frame 0 is outside the graph (frames 1-6)"),
        ("shot.toml --frames 3-1", "--frames: '3-1' is an empty range"),
        ("shot.toml --frames much", "--frames: 'much' is not a valid frame set"),
        ("shot.toml --set seed.vale=3", "unknown setting 'vale' (did you mean 'value'?)"),
        ("shot.toml --set seed.value=three", 'value = "three" is not allowed (a number'),
        ("shot.toml --set sed.value=3", "cannot set 'sed.value' (did you mean 'seed'?)"),
        ("shot.toml --set seed.value", "'seed.value' is not an assignment (NODE.SETTING=VALUE)"),
        ("shot.toml --to lits", "no node 'lits' (did you mean 'list'?)"),
        ("shto.toml", "shto.toml: no such file"),
        ("shto", "no graph 'shto' (a graph file, or one that is shipped"),
        ("nodes", "nodes: not a file"),
        ("shot.toml --cache shot.toml", "is a file"),
        ("shot.toml --cache shot.toml/cache", "Not a directory"),
        ("shot.toml -j 0", "0 is not in the range"),
        ("shot.toml -j many", "'many' is not a valid integer"),
        ("", "Missing argument 'GRAPH'"),
    ],
)
def test_bad_input_is_one_message_and_touches_nothing(arguments, message, shot, hairpipe):
    before = {path.name for path in shot.parent.iterdir()}
    result = hairpipe(f"run {arguments}")
    assert (result.exit_code, result.stdout) == (2, "")
    assert message in result.stderr and "Traceback" not in result.stderr
    assert {path.name for path in shot.parent.iterdir()} - {"cache"} == before


def test_a_cache_that_cannot_be_written_to_is_refused_before_anything_is_computed(shot, hairpipe, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write anywhere
    result = hairpipe("run shot.toml")
    assert result.exit_code == 2
    cache = shot.parent / "cache"
    what = "'seed' has to be computed, and the store cannot be written to"
    right = "--cache FOLDER of your own, or permission to write"
    assert result.stderr == f"hairpipe: {cache}: {what} ({right})\n"
    assert not (shot.parent / "tally").exists()


def test_a_shipped_graph_publishes_below_the_current_folder(shot, hairpipe, monkeypatch, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    monkeypatch.setattr(source, "shipped_graphs", lambda: {"toy": shot})
    shot.write_text(shot.read_text().replace('"out/', '"../out/toy/'))
    monkeypatch.chdir(elsewhere)
    result = hairpipe("run toy -j1")
    assert "list     out/toy/list.txt" in result.stdout
    assert sorted(path.name for path in elsewhere.iterdir()) == ["cache", "out"]
    assert not (shot.parent.parent / "out").exists()


def test_an_interrupted_run_reports_it_and_keeps_what_it_has(failing, hairpipe):
    command = [*START, "run", "shot.toml", "-j2", "--set", "bad.how=slow"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    for line in process.stderr:
        if line == "list: done\n":
            break
    process.send_signal(signal.SIGINT)
    *_, last = process.stderr.read().splitlines()
    assert process.wait() == 130
    assert last == "hairpipe: interrupted; computed results are kept, and the same command resumes"
    assert json.loads(hairpipe("run shot.toml -j1 --json --to list").stdout)["evaluated"] == 0


def test_a_terminal_gets_bars_and_the_key_for_interrupt_works(failing):
    process, terminal = pty.fork()
    if process == 0:
        os.execv(sys.executable, [*START, "run", "shot.toml", "-j2", "--set", "bad.how=slow"])
    output, end = b"", time.monotonic() + 60
    while b"5/6" not in output and time.monotonic() < end:
        output += os.read(terminal, 4096)
    os.write(terminal, b"\x03")
    try:
        while data := os.read(terminal, 4096):
            output += data
    except OSError:  # the other end is gone
        pass
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 130
    text = output.decode()
    assert "bad" in text and "\u2501" in text and "hairpipe: interrupted" in text
