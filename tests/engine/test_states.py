"""States that are only in the memory of a worker: who waits for them, and what is lost with the worker."""

import os
import signal

import pytest

from hairpipe.engine.plan.tasks import Task

from .conftest import wait_for

AT_SEVEN = """

def at_seven(frame):
    path = Path(os.environ["TOY_TALLY"] + ".once")
    if frame == 7 and not path.exists():
        path.touch()
        {act}


def numeral(value)"""
KILLED = {
    "worker": "os.kill(os.getpid(), signal.SIGKILL)",
    "coordinator": "os.kill(os.getppid(), signal.SIGKILL); __import__('time').sleep(60)",
    "interrupted": "os.kill(os.getppid(), signal.SIGINT); __import__('time').sleep(60)",
}
WAITS = """while not Path(os.environ["TOY_TALLY"] + ".gate").exists():
            __import__("time").sleep(0.02)"""


def act_at_seven(shot, act: str) -> None:
    """Have the scan do something in its first evaluation of frame 7; the checkpoint before is frame 4."""
    shot.edit("tally.py", "\n\ndef numeral(value)", AT_SEVEN.format(act=act))
    shot.edit("add_up.py", "import numeral, tally", "import at_seven, numeral, tally")
    shot.edit("add_up.py", "    if time.frame == warn", "    at_seven(time.frame)\n    if time.frame == warn")


@pytest.mark.parametrize("who", KILLED)
def test_a_killed_run_loses_what_it_computed_since_the_last_written_state(shot, undisturbed, who):
    act_at_seven(shot, KILLED[who])
    process = shot.start(jobs=1)
    process.communicate(timeout=60)
    assert process.returncode == {"worker": 1, "coordinator": -signal.SIGKILL, "interrupted": 130}[who]
    assert shot.tally()["add_up"] == 7
    reasons = {name: entry.reason for name, entry in shot.plan().items() if entry.status == "run"}
    assert reasons["sum@5"] == reasons["sum@6"] == "its full state, needed to continue, was not kept"
    assert shot.run().exit_code == 0
    assert shot.tally()["add_up"] == 6, "frames 5 and 6 again, then 7 to 10"
    assert shot.results() == undisturbed["results"]


def test_a_run_waits_for_a_state_in_the_memory_of_another(shot, undisturbed):
    """Nothing is computed twice; a plan calls the frames up to there cached."""
    act_at_seven(shot, WAITS)
    first = shot.start(jobs=1)
    wait_for(lambda: shot.has_called("add_up 7"))
    assert [shot.plan()[f"sum@{frame}"].status for frame in (4, 5, 6)] == ["cached"] * 3
    second = shot.start(jobs=1)
    (shot.folder / "tally.gate").touch()
    assert [shot.outcome(process)["failures"] for process in (first, second)] == [[], []]
    assert shot.tally()["add_up"] == 10 and shot.results() == undisturbed["results"]


def test_a_run_goes_on_from_the_last_written_state_of_one_that_was_killed_meanwhile(shot, undisturbed):
    act_at_seven(shot, WAITS)
    first = shot.start(jobs=1)
    wait_for(lambda: shot.has_called("add_up 7"))
    second = shot.start(jobs=1)
    first.kill()
    first.communicate()
    assert shot.outcome(second)["failures"] == []
    assert shot.tally()["add_up"] == 7 + 6 and shot.results() == undisturbed["results"]


def test_a_state_is_written_while_its_scan_waits_for_an_input(shot, undisturbed):
    shot.edit("tally.py", "IN_WORKER =", "from hairpipe.engine.worker import worker\nworker.IDLE = 0.05\nIN_WORKER =")
    shot.edit("move_seed.py", "return numeral", "wait(time.frame)\n    return numeral")
    gate = "def wait(frame):\n    while frame == 7 and not Path(os.environ['TOY_TALLY'] + '.gate').exists():\n"
    shot.edit("move_seed.py", "@node", gate + "        clock.sleep(0.02)\n\n\n@node")
    shot.edit("move_seed.py", "from typing", "import os\nimport time as clock\nfrom pathlib import Path\nfrom typing")
    process = shot.start(jobs=1)
    wait_for(lambda: shot.store.has(undisturbed["results"]["sum@6"]["state"]))
    (shot.folder / "tally.gate").touch()
    assert shot.outcome(process)["failures"] == []
    assert {name: found for name, found in shot.results().items() if name != "list"} == {
        name: found for name, found in undisturbed["results"].items() if name != "list"
    }


def test_a_run_that_stops_after_a_failure_writes_the_state_that_it_has(shot):
    """Another branch fails while the scan is at frame 7, whose state nothing else would have written."""
    shot.add('[wrong]\ntype = "go_wrong"\nin.number = "move"\nat = 1\n')
    wait = """while not Path(os.environ["TOY_TALLY"] + ".once").exists():
            clock.sleep(0.02)
        if how == "raise":"""
    shot.edit("go_wrong.py", 'if how == "raise":', wait)
    act_at_seven(shot, "__import__('time').sleep(1.0)")
    assert [failure.kind for failure in shot.run(jobs=2).failures] == ["node"]
    assert shot.tally()["add_up"] == 7
    assert shot.run(keep_going=True).exit_code == 1
    assert shot.tally()["add_up"] == 3


def test_a_host_without_the_state_waits_and_takes_over_where_it_is_written(shot, undisturbed, machines):
    made = machines(in_turn=True)
    assert shot.run().exit_code == 0
    assert shot.tally()["add_up"] == 10 and shot.results() == undisturbed["results"]
    replied = made[-1].replied
    assert replied["a", True] and replied["b", True], "both were asked while the other had the state"
    assert replied["a", False] > 1 and replied["b", False] > 1, "the scan has moved"


def test_a_scan_whose_host_died_goes_on_elsewhere(shot, undisturbed, machines):
    """Its worker is killed between two frames; the other host has no state and begins at the last written one."""
    made = machines(in_turn=True)

    def kill(event):
        if event.kind == "finished" and event.task == Task("sum", 6):
            for engine in made[-1].engines.values():
                for member in [member for member in engine.host.members if member.held]:
                    os.kill(member.process.pid, signal.SIGKILL)
                    member.process.wait()
                    engine.host.members.remove(member)

    assert shot.run(report=kill).exit_code == 0
    assert shot.tally()["add_up"] == 12 and shot.results() == undisturbed["results"], "frames 5 and 6 again"
