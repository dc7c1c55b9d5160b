"""Runs that are killed: the next one goes on, and ends with the bytes of a run that nobody disturbed."""

import random
import signal
import time
from pathlib import Path

import pytest

from hairpipe.engine.store.atomic import is_left_over

from .conftest import PATIENCE, wait_for


def resumed(shot):
    """Finish a run; its results, and what it published."""
    assert shot.run().exit_code == 0
    assert list((shot.store.root / "tmp").iterdir()) == [], "nothing of the killed run is left"
    return {"results": shot.results(), "text": (shot.folder / "out" / "list.txt").read_text()}


@pytest.mark.parametrize("rename", [1, 2, 7, 18])
def test_killed_between_write_and_rename(shot, undisturbed, rename):
    """Worker and coordinator die when a whole temporary file is about to get its name."""
    process = shot.start(jobs=1, TOY_KILL_AT_RENAME=str(rename))
    process.communicate(timeout=PATIENCE)
    assert process.returncode == -signal.SIGKILL
    wait_for_workers(shot)
    assert any((shot.store.root / "tmp").iterdir()), "the kill did hit the gap"
    assert resumed(shot).items() <= undisturbed.items()


def test_killed_at_any_moment(shot, undisturbed):
    moments = random.Random(7)
    for _ in range(3):
        process = shot.start(jobs=2)
        lines = moments.randint(1, 6)
        while process.poll() is None and tally_lines(shot) < lines:
            time.sleep(0.002)
        process.kill()
        process.communicate()
        wait_for_workers(shot)
        (shot.folder / "tally").unlink(missing_ok=True)
    assert resumed(shot).items() <= undisturbed.items()


def test_worker_dies_with_its_coordinator(shot):
    shot.add('[slow]\ntype = "go_wrong"\nin.number = "move"\nhow = "slow"\nat = 1\n')
    process = shot.start(jobs=2)
    wait_for(lambda: shot.has_called("go_wrong 1"))
    process.kill()
    process.communicate()
    wait_for_workers(shot)


def test_two_processes_share_the_work(shot):
    """Each evaluation is made once, by one or the other."""
    shot.change("[1, 10]", "[1, 40]")
    outcomes = [shot.outcome(process) for process in [shot.start(jobs=1), shot.start(jobs=1)]]
    assert [outcome["failures"] for outcome in outcomes] == [[], []]
    counts = shot.tally()
    assert counts == {"make_seed": 1, "move_seed": 40, "add_up": 40, "write_list": 1}
    assert sum(outcome["evaluated"] for outcome in outcomes) == 82


def tally_lines(shot) -> int:
    path = shot.folder / "tally"
    return len(path.read_text().splitlines()) if path.exists() else 0


def wait_for_workers(shot) -> None:
    """Wait until no worker that was started with this shot's nodes runs any more.

    One that dies has no command line any more before it is gone; until then what it left counts as in the making.
    """

    def none_left() -> bool:
        left = (shot.store.root / "tmp").glob("*.tmp")
        return all(map(is_left_over, left)) and not any(is_worker_of(shot, path) for path in Path("/proc").iterdir())

    wait_for(none_left)


def is_worker_of(shot, process: Path) -> bool:
    try:
        command = (process / "cmdline").read_bytes()
    except OSError:
        return False
    return b"hairpipe.engine.worker.worker" in command and str(shot.nodes).encode() in command
