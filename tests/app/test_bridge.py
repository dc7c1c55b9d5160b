"""The protocol of JSON lines: requests and events, cancellation, ends of processes, damaged lines."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hairpipe
from hairpipe.app import bridge
from hairpipe.app.api.node_types import document, node_types
from hairpipe.app.api.reports import Event as RunEvent
from hairpipe.app.api.reports import Task
from hairpipe.app.bridge import Bridge
from hairpipe.engine.worker import machine_code

from .cli.conftest import START
from .page.conftest import SHOT, until, write_shot

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "bridge.md"
WAITING = '\n[wait]\ntype = "stay"\nin.hair = "lag"\nuntil = "gate"\n'
FAILING = '\n[bad]\ntype = "tear"\nin.hair = "lag"\n'
CACHED = RunEvent("cached", Task("hair", 1))
MOMENTS = 3  # number of runs that are cancelled
Event = dict[str, Any]
Step = dict[str, Any] | bytes | Callable[[list[Event]], object]


class Client:
    """The other side of a bridge in this process: requests, and waits for events, in their order."""

    def __init__(self, steps: tuple[Step, ...], stays: bool) -> None:
        self.events: list[Event] = []
        self._steps = iter([*steps, lambda events: not stays or self.is_answered()])
        self._asked = 0

    def is_answered(self) -> bool:
        return sum(event["event"] in ("done", "error") for event in self.events) >= self._asked

    def __iter__(self) -> Iterator[bytes]:
        for step in self._steps:
            if callable(step):
                with suppress(AssertionError):  # waited in vain: the input ends, and the test sees the events so far
                    until(lambda step=step: step(self.events), 20.0)
            else:
                self._asked += 1
                yield step if isinstance(step, bytes) else json.dumps(step).encode()

    def write(self, line: bytes) -> None:
        assert line.count(b"\n") == 1 and line.endswith(b"\n")
        self.events.append(json.loads(line))

    def flush(self) -> None: ...


def talk(*steps: Step, stays: bool = True) -> list[Event]:
    """Serve requests, and return the events after the first; with `stays`, the input ends after the last answer."""
    client = Client(steps, stays)
    Bridge(client, client).serve()
    assert client.events[0]["event"] == "hello"
    return client.events[1:]


def of_kind(events: list[Event], *kinds: str) -> list[Event]:
    return [event for event in events if event["event"] in kinds]


def has(kind: str, **fields: Any) -> Callable[[list[Event]], bool]:
    return lambda events: any(event.items() >= (fields | {"event": kind}).items() for event in events)


@pytest.fixture
def shot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The file `shot.toml` in the current folder: hair of 300 strands that swings, a simulation and pictures of it."""
    monkeypatch.setenv("HAIRPIPE_TRUST", str(tmp_path / "nodes"))
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(machine_code, "kernel_modules", lambda: iter(()))
    monkeypatch.chdir(tmp_path)
    before = set(sys.modules)
    yield write_shot(tmp_path)
    for name in set(sys.modules) - before:
        if str(tmp_path) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


def test_first_line_names_the_versions():
    client = Client((), stays=True)
    Bridge(client, client).serve()
    python = ".".join(map(str, sys.version_info[:3]))
    assert client.events == [{"event": "hello", "protocol": 1, "hairpipe": hairpipe.__version__, "python": python}]


def test_types_are_described_as_by_the_command():
    names = ["simulate_hair", "export_usd"]
    [done] = talk({"id": "a", "do": "describe", "types": names})
    types = {name: document(node_types().find(name)) for name in names}
    assert done == json.loads(json.dumps({"event": "done", "id": "a", "types": types}))


def test_plan_run_and_get_agree(shot):
    plan = {"do": "plan", "graph": "shot.toml", "frames": "2-4"}
    run = {"do": "run", "graph": "shot.toml", "frames": "2-4", "jobs": 1, "live": {"lag": "live", "hair": "live"}}
    get = {"do": "get", "graph": "shot.toml", "value": "lag@3", "output": "lag.npz"}
    events = talk(plan | {"id": 1}, run | {"id": 2}, plan | {"id": 3}, run | {"id": 4}, get | {"id": 5})
    first, again = ([event for event in events if event["id"] == number] for number in (2, 4))
    before, ran, after, reran, got = of_kind(events, "done")
    assert before["to_run"]["lag"] == 4 and before["frames_to_run"]["lag"] == "1-4" and before["seconds"] is None
    assert before["tasks"][0] == {"node": "ball", "frame": None, "status": "run", "reason": "never evaluated"}
    assert after["to_run"] == after["frames_to_run"] == {} and after["seconds"] == 0.0
    total = sum(first[0]["totals"].values())
    assert first[0]["totals"] == before["to_run"] and first[0]["event"] == "begun"
    assert (ran["exit_code"], ran["computed"], ran["cached"]) == (0, total, 0) and ran["seconds"] > 0.0
    assert (reran["computed"], reran["cached"]) == (0, total)
    last = of_kind(first, "progress")[-1]
    assert (last["done"], last["total"], last["seconds_left"], last["cached"]) == (total, total, 0.0, False)
    assert of_kind(again, "progress")[-1]["cached"]
    files = [{(one["node"], one["frame"]): one["file"] for one in of_kind(found, "frame")} for found in (first, again)]
    assert files[0] == files[1] and files[0].keys() == {
        (node, frame) for node in ("hair", "lag") for frame in range(1, 5)
    }
    assert {(one["strands"], one["points"]) for one in of_kind(events, "frame")} == {(300, 3600)}
    assert got["bytes"] == Path(got["path"]).stat().st_size
    np.testing.assert_array_equal(
        np.fromfile(files[0]["lag", 3], "<f4").reshape(-1, 3), np.load("lag.npz")["points"].astype("<f4")
    )


def test_settings_of_a_request_change_nothing_else(shot):
    plan = {"id": 1, "do": "plan", "graph": "shot.toml", "to": ["ball"], "cache": "other"}
    run = plan | {"do": "run", "id": 2, "set": {"ball.radius": "0.05"}}
    events = talk(run, plan | {"id": 3, "set": run["set"]}, plan | {"id": 4})
    ran, same, other = of_kind(events, "done")
    assert ran["computed"] == 1 and same["to_run"] == {} and other["to_run"] == {"ball": 1}
    assert other["seconds"] > 0.0 and (shot.parent / "other").is_dir() and shot.read_text() == SHOT


REFUSING = '''"""A node that refuses its input."""

from hairpipe.engine import node
from hairpipe.errors import BadInput
from hairpipe.values import Strands, Table


@node(frames="each")
def refuse(hair: Strands) -> Table:
    """Refuse hair."""
    raise BadInput("not a clip", where="walk.bvh:7", right="a clip")
'''


def test_idle_workers_end_and_others_start(shot, monkeypatch):
    monkeypatch.setattr(bridge, "IDLE", 0.05)
    run = {"id": 1, "do": "run", "graph": "shot.toml", "to": ["ball"], "jobs": 1}
    again = run | {"id": 2, "set": {"ball.radius": "0.2"}}
    client = Client((run, has("done", id=1), lambda _: not served._spare, again), stays=True)
    served = Bridge(client, client)
    served.serve()
    assert [done["computed"] for done in of_kind(client.events, "done")] == [1, 1]


def test_failures_warnings_and_published_files_are_events(shot):
    (shot.parent / "nodes" / "refuse.py").write_text(REFUSING)
    published = SHOT.replace('type = "paint"', 'type = "paint"\npublish = "out/####.png"')
    shot.write_text(published + FAILING + '\n[refused]\ntype = "refuse"\nin.hair = "lag"\n')
    run = {"do": "run", "graph": "shot.toml", "jobs": 1, "to": ["picture", "bad"]}
    events = talk(
        *[run | {"id": 1, "frames": "3", "to": ["refused", "bad"], "keep_going": True, "tasks": True}],
        *[run | {"id": 2, "frames": "4-5"}, run | {"id": 3, "frames": "4-5", "publish": False}],
    )
    failed = {event["node"]: (event["what"], event["where"], event["right"]) for event in of_kind(events, "failed")}
    fault = ("ValueError: </script> at frame 3", None, None)
    assert failed == {"bad": fault, "refused": ("not a clip", "walk.bvh:7", "a clip")}
    assert has("task", id=1, node="lag", frame=1, status="computed")(events)
    assert has("task", id=1, node="bad", frame=3, status="failed")(events)
    assert {event["id"] for event in of_kind(events, "task")} == {1}
    assert has("warning", id=2, node="bad", frame=4, message="frayed")(events)
    assert [done["exit_code"] for done in of_kind(events, "done")] == [1, 0, 0]
    paths = {Path(event["path"]) for event in of_kind(events, "published")}
    assert paths == {shot.parent / "out" / f"000{frame}.png" for frame in (4, 5)}
    assert all(path.is_file() for path in paths)


def test_cancelled_run_keeps_its_results(shot):
    shot.write_text(SHOT + WAITING)
    run = {"do": "run", "graph": "shot.toml", "jobs": 1, "to": ["wait"]}
    cancel = {"do": "cancel"}
    events = talk(
        *[run | {"id": 1}, run | {"id": 2}, has("progress", id=1, done=11), run | {"id": 1}],
        *[cancel | {"id": 3, "run": 2}, cancel | {"id": 4, "run": 1}, has("done", id=2)],
        *[lambda _: Path("gate").write_text("open"), cancel | {"id": 5, "run": 1}, run | {"id": 6}],
    )
    done = {event["id"]: event for event in of_kind(events, "done")}
    ends = [(done[number]["exit_code"], done[number]["computed"], done[number]["cached"]) for number in (1, 2, 6)]
    assert ends == [(130, 11, 0), (130, 0, 0), (0, 1, 11)]
    assert [event["what"] for event in of_kind(events, "error")] == [
        "a run 1 is in progress",
        "no run 1 is in progress",
    ]


def test_run_is_cancelled_at_any_moment(shot):
    draw = random.Random(68)
    steps = list[Step]()
    for number in range(MOMENTS):
        settings = {"hair.strands": str(201 + number)}
        steps.append({"id": number, "do": "run", "graph": "shot.toml", "to": ["lag"], "jobs": 2, "set": settings})
        steps.append(lambda _: time.sleep(draw.uniform(0.0, 0.3)) or True)
        steps += [
            {"id": f"c{number}", "do": "cancel", "run": number},
            lambda events, n=number: has("done", id=n)(events),
        ]
    steps.append({"id": "last", "do": "run", "graph": "shot.toml", "to": ["lag"]})
    done = {event["id"]: event for event in of_kind(talk(*steps), "done")}
    assert {done[number]["exit_code"] for number in range(MOMENTS)} <= {0, 130} and done["last"]["exit_code"] == 0


def test_wedges_and_unsaved_texts_are_planned_and_run(shot):
    wedge = '\n[wedge.feel]\naxes = { "hair.wave.height" = [0.03, 0.05] }\nshow = ["picture"]\n'
    plan = {"do": "plan", "graph": "shot.toml", "text": SHOT + wedge, "frames": "1-2", "wedge": "feel", "to": ["hair"]}
    events = talk(plan | {"id": 1}, plan | {"id": 2, "do": "run", "jobs": 1}, plan | {"id": 3})
    before, ran, after = events[0], events[-2], events[-1]
    assert before["to_run"] == {"plate": 1, "hair": 4} and before["frames_to_run"] == {"hair": "1-2"}
    assert (ran["computed"], after["to_run"]) == (5, {}) and shot.read_text() == SHOT


@pytest.mark.parametrize("number", [0, signal.SIGINT], ids=["end", "ctrl_c"])
def test_end_of_the_input_and_ctrl_c_cancel_a_run(number, shot):
    shot.write_text(SHOT + WAITING)
    run = {"id": 1, "do": "run", "graph": "shot.toml", "jobs": 1, "to": ["wait"]}
    steps: list[Step] = [run, {"id": 2, "do": "describe", "types": []}, has("progress", done=11)]
    steps += [lambda _: os.kill(os.getpid(), number) or True, has("done", id=2)] if number else []
    events = talk(*steps, stays=False)
    assert [(done["id"], done.get("exit_code")) for done in of_kind(events, "done")] == [(1, 130), (2, None)]


def test_progress_is_written_twenty_times_a_second_and_at_the_end(shot):
    lines: list[Event] = []
    report = bridge.RunReport(hairpipe.load("shot.toml"), {}, 1, lambda event, **fields: lines.append(fields))
    begun = time.monotonic()
    with report.sampled():
        for number in range(200):
            report(CACHED if number else RunEvent("begun", totals=(("hair", 200),)))
            time.sleep(0.001)
    assert 2 <= len(lines) - 1 <= 21.0 * (time.monotonic() - begun) + 1.0
    assert (lines[-1]["done"], lines[-1]["total"], lines[-1]["cached"]) == (199, 200, True)


TABLES = {"hair": {"type": "swing", "in": {"plate": "plate"}, "strands": 20, "wave": {"height": 0.03}}}
HAND_MADE = """# Made by hand.
schema = 1
frames = [1, 5] # of the film
fps = 24

[plate]
type = "make_plate"

[old_hair]
type = "swing"
in.plate = "plate"

# What a person added.
[lag]
type = "trail" # simulated
in.hair = "hair"
"""


def test_tables_are_written_and_those_of_others_are_kept(shot):
    write = {"do": "write", "graph": "shot.toml", "head": {"frames": [1, 9], "fps": 24.0}, "tables": TABLES}
    shot.write_text(HAND_MADE)
    events = talk(*(write | {"id": number, "owned": ["hair", "old_*"]} for number in (1, 2)))
    assert [event["changed"] for event in events] == [True, False]
    expected = HAND_MADE.replace("[1, 5]", "[1, 9]").replace('[old_hair]\ntype = "swing"\nin.plate = "plate"\n\n', "")
    hair = '\n[hair]\ntype = "swing"\nin.plate = "plate"\nstrands = 20\nwave.height = 0.03\n'
    assert shot.read_text() == expected + hair


def test_file_is_made_with_its_folder(shot):
    head = {"frames": [1, 2], "fps": 25.0}
    tables = {"head": {"type": "make_bust"}, "groom": {"type": "grow_groom", "in": {"scalp": "head"}}}
    write = {"id": 1, "do": "write", "graph": "new/made.toml", "head": head, "tables": tables}
    [done] = talk(write)
    assert done["changed"]
    made = 'schema = 1\nframes = [1, 2]\nfps = 25.0\n\n[head]\ntype = "make_bust"\n'
    assert Path("new/made.toml").read_text() == f'{made}\n[groom]\ntype = "grow_groom"\nin.scalp = "head"\n'


def test_fault_of_a_table_has_a_place_and_leaves_the_file_untouched(shot):
    write = {"do": "write", "graph": "shot.toml", "tables": {}}
    faults = {
        ("plate", "size"): {"tables": {"plate": {"type": "make_plate", "size": "large"}}},
        ("hair", "in.plate"): {"tables": {"hair": TABLES["hair"] | {"in": {"plate": "flat"}}}},
        ("hair", "wave.height"): {"tables": {"hair": TABLES["hair"] | {"wave": {"height": 2.0}}}},
        ("hair", "type"): {"tables": {"hair": {"strands": 3}}},
        ("hair", "a b"): {"tables": {"hair": {"a b": 1}}},
        ("hair", "strands"): {"tables": {"hair": {"strands": None}}},
        ("lag", "in.hair"): {"owned": ["ha*"]},
        (None, "fps"): {"head": {"fps": 0}},
    }
    events = talk(*(write | fields | {"id": number} for number, fields in enumerate(faults.values())))
    assert [(event["node"], event["setting"]) for event in of_kind(events, "error")] == [*faults]
    [error] = talk({"id": 1, "do": "plan", "graph": "shot.toml", "set": {"hare.strands": "3"}})
    assert (error["node"], error["setting"], error["right"]) == ("hare", "strands", "did you mean 'hair'?")
    assert shot.read_text() == SHOT


def test_conversation_on_the_page_has_the_same_answers(shot):
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    asked, answered = ([json.loads(line[2:]) for line in lines if line.startswith(mark)] for mark in ("> ", "< "))
    writes = {request["id"]: request for request in asked if request["do"] == "write"}
    assert len(writes) == 2 and talk(*writes.values()) == [event for event in answered if event["id"] in writes]
    types = {request["do"] for request in asked} | {event["event"] for event in answered}
    assert types <= bridge.REQUESTS.keys() | {"begun", "progress", "frame", "done", "error"}


def test_page_lists_every_field():
    text = PAGE.read_text(encoding="utf-8")
    named = {name for do, kinds in bridge.REQUESTS.items() for name in (do, *kinds)}
    assert not [name for name in named if f"`{name}`" not in text]


FAULTS = {
    b"": "not JSON",
    b"{": "not JSON",
    b"\xff": "not JSON",
    b"[" * 100_000: "not JSON",
    b'{"id": NaN}': "not JSON",
    b"3": "not a JSON object",
    b"{}": "do = None is not a request",
    b'{"id": 1, "do": "planet"}': "do = 'planet' is not a request",
    b'{"id": 1, "do": ["plan"]}': "do = ['plan'] is not a request",
    b'{"id": 1, "do": "plan"}': "plan lacks the field 'graph'",
    b'{"do": "plan", "graph": "shot.toml"}': "plan lacks the field 'id'",
    b'{"id": true, "do": "plan", "graph": "shot.toml"}': "id = True",
    b'{"id": 1e999, "do": "plan", "graph": "shot.toml"}': "id = inf",
    b'{"id": 1, "do": "plan", "graph": 3}': "graph = 3",
    b'{"id": 1, "do": "plan", "graph": "a\\nb"}': "graph = 'a\\nb'",
    b'{"id": 1, "do": "plan", "graph": "\\ud800"}': "",
    b'{"id": 1, "do": "write", "graph": "\\ud800.toml", "tables": {}}': "UnicodeEncodeError",
    b'{"id": 1, "do": "plan", "graph": "absent.toml"}': "no such file",
    b'{"id": 1, "do": "plan", "graph": "shot.toml", "frames": "5-1"}': "'5-1' is an empty range",
    b'{"id": 1, "do": "plan", "graph": "shot.toml", "frame": "1"}': "plan has no field 'frame'",
    b'{"id": 1, "do": "run", "graph": "shot.toml", "jobs": 0}': "jobs = 0",
    b'{"id": 1, "do": "run", "graph": "shot.toml", "live": {"ball": "x"}}': "'ball' has no hair per frame",
    b'{"id": 2, "do": "run", "graph": "shot.toml", "set": {"ball.radius": "far"}}': 'radius = "far" is not allowed',
    b'{"id": 1, "do": "get", "graph": "shot.toml", "value": "lag", "output": "x.npz"}': "'lag' has a value per frame",
    b'{"id": 1, "do": "cancel", "run": 7}': "no run 7 is in progress",
    b'{"id": 1, "do": "describe", "types": ["a", 1]}': "types = ['a', 1]",
}


def test_faulty_request_has_one_error_and_the_next_is_read(shot, monkeypatch):
    monkeypatch.setattr(bridge, "MOST_BYTES", 1 << 18)
    long = b'{"id": 1, "do": "describe", "types": ["' + b"x" * (1 << 20) + b'"]}'
    events = talk(*FAULTS, long, {"id": "last", "do": "describe", "types": []})
    assert [event["event"] for event in events] == ["error"] * (len(FAULTS) + 1) + ["done"]
    found = "\n".join(event["what"] for event in events[:-1])
    assert not [what for what in (*FAULTS.values(), "the line is too long") if what not in found], found
    assert Counter(event["id"] for event in events) == {None: 11, 1: len(FAULTS) - 11, 2: 1, "last": 1}


@pytest.mark.parametrize("end", [b"", b"\n"])
def test_lines_are_read_whole_and_long_ones_are_cut(end, monkeypatch):
    monkeypatch.setattr(bridge, "MOST_BYTES", 10)
    monkeypatch.setattr(bridge, "CHUNK", 7)
    reading, writing = os.pipe()
    os.write(writing, b"one\n\n" + b"x" * 100 + b"\nthe third\nlast" + end)
    os.close(writing)
    one, blank, long, third, last = bridge.read_lines(reading)
    assert (one, blank, third, last) == (b"one", b"", b"the third", b"last")
    assert len(long) > 10 and set(long) == set(b"x")
    os.close(reading)


REQUESTS = [
    {"id": 1, "do": "describe", "types": ["preview"]},
    {"id": "x", "do": "plan", "graph": "shot.toml", "frames": "1-2", "to": ["hair"], "set": {"ball.radius": "0.2"}},
    {"id": 2.5, "do": "write", "graph": "shot.toml", "head": {"fps": 0}, "tables": {}, "owned": ["hair*"]},
    {"id": 3, "do": "cancel", "run": 9},
    {"id": 4, "do": "get", "graph": "shot.toml", "value": "lag@2", "output": "lag.npz"},
]


def test_damaged_requests_have_one_answer_each(shot):
    draw = random.Random(68)
    lines = []
    for _ in range(400):
        line = bytearray(json.dumps(draw.choice(REQUESTS)).encode())
        for _ in range(draw.randrange(1, 4)):
            place = draw.randrange(len(line))
            line[place : place + draw.randrange(3)] = draw.choice([b"", bytes([draw.randrange(256)]), b'"', b"}", b"1"])
        lines.append(bytes(line).replace(b"\n", b" "))
    events = talk(*lines, {"id": "last", "do": "describe", "types": []})
    assert len(events) == len(lines) + 1 and {event["event"] for event in events} <= {"done", "error"}
    assert all(event.keys() >= {"what", "where", "right", "node", "setting"} for event in of_kind(events, "error"))
    assert shot.read_text() == SHOT


PARENT = f"""import subprocess, sys
child = subprocess.Popen({[*START, "bridge"]!r}, stdin=subprocess.PIPE)
print(child.pid, flush=True)
child.stdin.write(sys.stdin.buffer.readline())
child.stdin.flush()
sys.stdin.read()
"""


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_killed_parent_ends_the_bridge_and_loses_nothing(shot):
    (shot.parent / "nodes" / "swing.py").open("a").write("\nprint('noise')\n")
    shot.write_text(SHOT + WAITING)
    run = {"id": 1, "do": "run", "graph": "shot.toml", "jobs": 1, "to": ["wait"]}
    line = json.dumps(run).encode() + b"\n"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen([sys.executable, "-c", PARENT], **pipes) as parent:
        pid = int(parent.stdout.readline())
        parent.stdin.write(line)
        parent.stdin.flush()
        while json.loads(parent.stdout.readline()).get("done") != 11:
            pass
        os.kill(parent.pid, signal.SIGKILL)
    until(lambda: not is_running(pid))
    child = subprocess.Popen([*START, "bridge"], **pipes)
    child.stdin.write(line)
    child.stdin.flush()
    [done] = of_kind(talk(run, lambda _: Path("gate").write_text("open")), "done")
    other = next(event for event in map(json.loads, child.stdout) if event["event"] == "done")
    assert done["exit_code"] == other["exit_code"] == 0
    assert sorted([(done["computed"], done["cached"]), (other["computed"], other["cached"])]) == [(0, 12), (1, 11)]
    assert child.communicate(timeout=20) == (b"", None) and child.returncode == 0
