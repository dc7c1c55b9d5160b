"""Forked workers of tests: what they are given is what started workers are given."""

import json
import os
import signal
import subprocess
from pathlib import Path

from hairpipe.engine.hosts import host as member

from .conftest import NO_JOB, local_engine

DESCRIPTION = """
    import json, os, signal, sys
    from pathlib import Path
    mask = os.umask(0)
    os.umask(mask)
    given = [Path("/proc/self/fd", str(place)).resolve().name for place in (0, 1, 2)]
    signals = sorted(signal.pthread_sigmask(signal.SIG_BLOCK, []))
    described = [dict(os.environ), sys.path, os.getcwd(), mask, given, signals, os.getpgrp()]
    Path(os.environ["TOY_TALLY"] + ".json").write_text(json.dumps(described))
"""


def description_of_worker(shot, value: int) -> list:
    """Run a node that describes its process; returns the description."""
    shot.run(to=["seed"], seed__value=value)
    path = Path(os.environ["TOY_TALLY"] + ".json")
    described = json.loads(path.read_text())
    path.unlink()
    return described


def test_it_is_given_what_a_started_worker_is_given(shot, monkeypatch):
    shot.edit("make_seed.py", '    tally("make_seed")\n', f'    tally("make_seed")\n{DESCRIPTION}')
    description_of_worker(shot, 0)  # since now, at the latest, there is a process to fork, in another folder
    monkeypatch.chdir(shot.folder)
    before = os.umask(0o27)
    forked = description_of_worker(shot, 1)
    monkeypatch.setattr(member, "subprocess", subprocess)
    started = description_of_worker(shot, 2)
    os.umask(before)
    assert forked == started


def test_its_end_is_that_of_a_child(shot):
    engine = local_engine(shot)
    engine.submit(NO_JOB)
    process = engine.host.members[0].process
    assert type(process).__name__ == "ForkedWorker" and process.poll() is None
    os.kill(process.pid, signal.SIGKILL)
    assert process.wait() == process.poll() == -signal.SIGKILL
    (reply,) = engine.replies(None)
    engine.close()
    assert reply["failure"]["message"] == "the worker process was ended by SIGKILL, possibly out of memory"
