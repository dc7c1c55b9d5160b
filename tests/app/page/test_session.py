"""A live page: edits, plan, run, save; and what others do to the file and the cache meanwhile."""

import json
import threading
from contextlib import closing
from itertools import islice
from pathlib import Path
from unittest.mock import ANY

import numpy as np
import pytest

import hairpipe.app.page.runs
from hairpipe.app.api.draft import EMPTY, load_draft
from hairpipe.app.api.shot import load
from hairpipe.app.page.runs import Job, Request, Runs
from hairpipe.app.page.session import Session
from hairpipe.errors import BadInput

from ..cli.commands.test_watch import ELSEWHERE
from .conftest import SHOT, until


def cells(session, node):
    return session.document("state")[0]["nodes"][node]["cells"]


def states(session, node):
    return [cell["state"] for cell in cells(session, node)]


def verdict(session):
    return session.document("state")[0]["verdict"]


def idle(session):
    return not verdict(session)["running"]


def test_an_edit_lists_the_tasks_to_run(session):
    assert states(session, "picture") == ["cached"] * 5
    session.edit("picture.red", "0.75")
    assert states(session, "picture") == ["run"] * 5 and states(session, "hair") == ["cached"] * 5
    assert cells(session, "picture")[0]["reason"] == "setting red 0.5 -> 0.75"
    session.edit("hair.wave.height", "0.05")
    assert states(session, "hair") == ["run"] * 5 and states(session, "reach") == ["depends"] * 5
    session.revert()
    assert states(session, "hair") == ["cached"] * 5


def test_an_edit_that_the_file_would_not_take_changes_nothing(session):
    revision = session.revision
    for target, text in (("hair.strands", "0"), ("hair.strandz", "1"), ("har.strands", "1"), ("hair", "1")):
        with pytest.raises(BadInput):
            session.edit(target, text)
        assert session.revision == revision and states(session, "hair") == ["cached"] * 5


def test_a_run_computes_the_plan_and_saving_changes_one_value(session, folder):
    session.edit("picture.red", "0.625")
    reported = verdict(session)["missing"]
    session.run([])
    with pytest.raises(BadInput, match="a run is in progress"):
        session.run([])
    until(lambda: idle(session))
    found = verdict(session)
    assert found["failures"] == [] and (found["computed"], found["missing"]) == (reported, 0) == (5, 0)
    assert states(session, "picture") == ["computed"] * 5
    assert (folder / "shot.toml").read_text() == SHOT
    session.edit("hair.strands", "301")
    session.save()
    text = (folder / "shot.toml").read_text()
    assert text == SHOT.replace("strands = 300 #", "strands = 301 #").replace("[reach]", "[reach]").replace(
        'type = "paint"\nin.hair = "hair"\n', 'type = "paint"\nin.hair = "hair"\nred = 0.625\n'
    )
    assert session.document("graph")[0]["edits"] == []


def test_the_selected_node_is_computed_at_one_frame(session, folder):
    session.edit("picture.red", "0.45")
    assert session.work("picture", 3) == {"counts": {"picture": 5}, "seconds": ANY, "now": 1, "reason": ""}
    session.change("edit", {"target": "picture.publish", "text": '"out/####.png"'})
    session.cook("picture", 3)
    until(lambda: idle(session))
    assert states(session, "picture") == ["run", "run", "computed", "run", "run"] and not (folder / "out").exists()
    session.cook("picture", 3)
    assert idle(session), "nothing is missing"


def test_a_value_that_is_dragged_is_computed_without_an_edit(session, shot):
    text, revision = session._history.text, session.drawn
    tried = lambda value: session.trial("hair.strands", value, "hair", 2)  # noqa: E731
    assert tried("222") == {"begun": True}
    until(lambda: "nodes" in tried("222"))
    (cell,) = tried("222")["nodes"]["hair"]["cells"]
    changed = shot.changed({"hair.strands": 222})
    assert len(changed.get("hair@2").offsets) == 223 and cell["frame"] == 2
    assert session.document(f"{cell['outputs']['']}.strands")[0]["total"] == 222
    assert session._history.text == text and session.drawn == revision and states(session, "hair") == ["cached"] * 5
    with pytest.raises(BadInput):
        tried("0")
    with pytest.raises(BadInput, match="simulation lag"):
        session.trial("hair.strands", "223", "lag", 2)
    session.edit("hair.strands", "222")
    assert states(session, "hair") == ["run", "computed", "run", "run", "run"]


def test_neither_a_simulation_nor_another_frame_is_computed_unasked(session, shot):
    session.edit("hair.wave.height", "0.06")
    with pytest.raises(BadInput, match="simulation lag"):
        session.cook("lag", 2)
    with closing(Session(shot, "1-2")) as part:
        part.edit("hair.wave.height", "0.06")
        assert part.work("hair", 2)["reason"] == "" and part.work("hair", 4)["reason"] == "other frames"
    assert session.work("lag", 2)["counts"] == {"hair": 5, "lag": 5} and idle(session)


def test_a_run_by_itself_gives_way_and_keeps_its_process(session):
    session.edit("picture.red", "0.35")
    session.cook("picture", 1)
    until(lambda: idle(session))
    process = session._runs.process.pid
    with session._lock:  # no run ends meanwhile
        session.edit("hair.strands", "80000")
        session.cook("picture", 2)
        session.edit("hair.strands", "299")
        session.cook("picture", 2)
        assert [one["label"] for one in session._runs.document()["queue"]] == ["picture@2"] * 2
        session.run(["picture"])
        assert [one["label"] for one in session._runs.document()["queue"]] == ["picture@2", "hair.strands = 299"]
    session.cook("picture", 4)
    until(lambda: idle(session))
    assert states(session, "picture") == ["computed"] * 5 and session._runs.last["failures"] == []
    assert session._runs.process.pid == process


def test_a_run_is_stopped(session):
    session.edit("hair.strands", "90000")
    session.run([])
    session.stop()
    until(lambda: idle(session))
    assert verdict(session)["interrupted"]


def test_runs_share_their_processes_until_code_changes_or_they_idle(session, folder, monkeypatch):
    def processes(red):
        session.edit("picture.red", red)
        session.run([])
        until(lambda: idle(session))
        assert verdict(session)["computed"] == 5
        runner = session._runs.process.pid
        return [runner, *Path(f"/proc/{runner}/task/{runner}/children").read_text().split()]

    first = processes("0.1")
    assert len(first) > 1 and processes("0.2") == first
    with (folder / "nodes" / "paint.py").open("a") as file:
        file.write("# another version\n")
    assert not set(processes("0.3")) & set(first)
    monkeypatch.setattr(hairpipe.app.page.runs, "IDLE", 0.0)
    runner = session._runs.process
    until(lambda: runner.poll() == 0)


def test_a_run_is_possible_after_its_process_was_killed(session):
    session.edit("picture.red", "0.15")
    session.run([])
    session._runs.process.kill()
    until(lambda: idle(session))
    assert verdict(session)["failures"] == ["the run ended with exit code -9"]
    session.run([])
    until(lambda: idle(session))
    assert states(session, "picture") in (["computed"] * 5, ["cached"] * 5)


def test_a_file_that_others_change_is_read_again(session, folder):
    revision = session.revision
    (folder / "shot.toml").write_text(SHOT.replace("strands = 300", "strands = 250"))
    until(lambda: session.revision > revision)
    until(lambda: states(session, "hair") == ["run"] * 5)
    (folder / "shot.toml").write_text(SHOT.replace("strands = 300", "strands = -1"))
    until(lambda: "strands = -1" in verdict(session)["note"])
    assert states(session, "hair") == ["run"] * 5
    (folder / "shot.toml").write_text(SHOT)
    until(lambda: states(session, "hair") == ["cached"] * 5)


def test_a_fault_of_the_plan_is_shown_until_it_is_gone(session):
    def fail(draft):
        raise BadInput("is missing", where="head.obj")

    note = lambda: verdict(session)["note"]  # noqa: E731
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(session, "_take", fail)
        session._replan()
        assert note() == "head.obj: is missing"
    until(lambda: note() == "")


def test_results_that_another_process_computes_are_shown(shot, folder, session):
    changed = shot.changed({"hair.strands": 260})
    session.edit("hair.strands", "260")
    keys = {str(entry.task): entry.key for entry in changed.plan()}
    lease = folder / "cache" / "lease" / keys["hair@3"]
    lease.parent.mkdir(exist_ok=True)
    revision = session.revision
    lease.write_text(json.dumps({"holder": ELSEWHERE, "host": "render-7"}))
    until(lambda: session.revision > revision)
    assert states(session, "hair") == ["run", "run", "running", "run", "run"]
    assert cells(session, "hair")[2]["reason"] == "on render-7"
    assert verdict(session)["hosts"] == {"render-7": 1}
    revision = session.revision
    lease.unlink()
    until(lambda: session.revision > revision)
    assert states(session, "hair") == ["run"] * 5
    revision = session.revision
    assert changed.run(to="hair", only=3, jobs=1).ok
    until(lambda: session.revision > revision)
    until(lambda: states(session, "hair") == ["run", "run", "cached", "run", "run"])


def test_a_result_missing_from_the_cache_is_a_message(session, shot):
    name = cells(session, "ball")[0]["outputs"][""]
    path = shot.object_path(name)
    kept = path.read_bytes()
    path.unlink()
    with pytest.raises(BadInput, match=r"was not kept|not in the store"):
        session.document(f"{name}.slices")
    path.write_bytes(b"damaged")
    with pytest.raises(BadInput):
        session.document(f"{name}.slices")
    path.unlink(missing_ok=True)
    path.write_bytes(kept)


def test_playing_uses_edited_settings(session, shot):
    assert session.document("graph")[0]["playable"] == ["lag"]
    messages = read_messages(session.play("lag", ""))
    for frame in (1, 2, 3, 4, 5, 1):
        head, codes = next(messages)
        places = np.array(head["low"]) + head["step"] * codes.reshape(-1, 3)
        assert head["frame"] == frame and head["total"] == 300
        assert np.abs(places - shot.get(f"lag@{frame}").points).max() <= 0.51 * head["step"]
    session.edit("lag.share", "1.0")
    following = (np.array(head["low"]) + head["step"] * codes.reshape(-1, 3) for head, codes in messages)
    hair = [shot.get(f"hair@{frame}").points for frame in range(1, 6)]
    assert any(min(np.abs(next(following) - points).max() for points in hair[2:]) < 1e-4 for _ in range(60))
    session.edit("hair.strands", "301")
    assert any("hair@1 has not been computed" in head.get("fault", "") for head, _ in islice(messages, 60))
    messages.close()


def read_messages(player):
    """Take messages apart, as the page does."""
    held = bytearray()

    def take(count):
        while len(held) < count:
            part = player.read()
            assert part, "it has ended"
            held.extend(part)
        taken = bytes(held[:count])
        del held[:count]
        return taken

    try:
        while True:
            head, body = np.frombuffer(take(8), "<u4")
            yield json.loads(take(int(head))), np.frombuffer(take(int(body)), "<u2").astype(float)
    finally:
        player.close()


def test_a_document_has_as_many_strands_as_asked_for(session):
    name = cells(session, "hair")[1]["outputs"][""]
    (_, whole), (some, packed) = (session.document(f"{name}.strands", most) for most in (None, 100))
    assert some["total"] == 300 and len(packed) < len(whole)
    assert {place["name"]: place["shape"] for place in some["arrays"]}["lengths"] == [100]


def test_a_result_is_explained(session):
    text = session.explain("hair", 2)
    assert text.startswith("cached") and '"height": 0.03' in text
    with pytest.raises(BadInput):
        session.explain("hair", 9)


def test_an_empty_graph_begins_with_a_shipped_one_and_copies_of_its_files(tmp_path, empty):
    with pytest.raises(BadInput, match="not a template"):
        empty.begin("../demo")
    empty.begin("demo")
    assert empty.document("graph")[0]["edits"] == ["begin with demo; assets/shake.bvh copied next to the graph"]
    assert empty.draft.shot.nodes.keys() == load("demo").nodes.keys() and not empty.draft.faults
    assert empty.draft.shot.nodes["film"].publish == tmp_path / "out/demo/film.webp"
    with pytest.raises(BadInput, match="not a template"):
        empty.begin("demo")
    empty.undo()
    assert empty._history.text == EMPTY
    empty.close()
    assert not (tmp_path / "assets" / "shake.bvh").exists(), "nothing was saved"
    (tmp_path / "assets" / "shake.bvh").write_text("another motion")
    again = Session(load_draft("new.toml", EMPTY, cache=tmp_path / "cache"))
    with closing(again), pytest.raises(BadInput, match="another file"):
        again.begin("demo")


def test_runs_are_dropped_by_number_and_report_a_failed_start(monkeypatch):
    def refused(*given, **more):
        raise OSError(11, "Resource temporarily unavailable")

    begun = []
    runs = Runs(threading.RLock(), *[lambda: None] * 3)
    monkeypatch.setattr(runs, "_begin", lambda: begun.append(runs.document()["queue"][0]["label"]))
    for name in "abc":
        runs.add(Request(Job("g", name, None, [], "c", None), name, "p"))
    runs._end({"failures": []})
    (active, waiting) = runs.document()["queue"]
    with pytest.raises(BadInput):
        runs.drop(active["number"])
    runs.drop(waiting["number"])
    assert begun == ["a", "b"] and [one["label"] for one in runs.document()["queue"]] == ["b"]
    runs._end({"failures": []})
    monkeypatch.undo()
    monkeypatch.setattr(hairpipe.app.page.runs.subprocess, "Popen", refused)
    runs.add(Request(Job("g", "d", None, [], "c", None), "d", "p"))
    assert not runs.document()["running"] and "did not start" in runs.last["failures"][0]
