"""Trials of one fault at every call of the file system in a run, one call after another.

Each trial has an empty store. In the run, one call fails, or is the last one; the next run is undisturbed, by another
process, and must end with the bytes of a run that nothing disturbed.
"""

import errno
import os
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.lease import KEY, read_lease
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.calls.file_layer import Call, FileLayer
from hairpipe.graphs.experiments.bench.calls.simulation import Killed, Processes, simulated
from hairpipe.graphs.experiments.bench.machines.end_state import CheckValue, differences, state_of
from hairpipe.graphs.experiments.bench.machines.trials import Truth
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report
from hairpipe.graphs.experiments.bench.toy_shot import ToyShot

MEMORY = next(filter(os.path.isdir, ("/dev/shm",)), None)
"""A folder in memory, where there is one."""
FRAMES = 4
LOST = 3
"""Evaluations that may be lost: the one that was made, and two frames whose states were not written."""
CONTENT = ("open", "open file", "write", "ftruncate", "truncate", "HDF5 write")
"""Calls that change the bytes of a file."""
FREE = ("chmod", "chown", "fchmod", "remove", "rmdir", "unlink", "utime")
"""Calls that write, and take no space."""
SOURCES = "hairpipe.engine.code._settled"
"""Digests that a process remembers of sources that were not written to lately."""
FAILED, REFUSED, EXCEPTION = "a run that fails", "a run that is refused", "an exception"
"""Ways to end."""


class Disturbance(NamedTuple):
    """What happens at a call.

    number   of the error; None: the process is killed
    kinds    of calls that it strikes
    lasting  whether every later call of these kinds fails, too
    torn     whether files that were not flushed lose their second half, as where the power fails
    """

    number: int | None
    kinds: Callable[[Call], bool]
    lasting: bool = False
    torn: bool = False


def writes(call: Call) -> bool:
    """Whether a call changes anything: to be killed before another call is to be killed before the next of these."""
    return call.writes


def takes_space(call: Call) -> bool:
    """Whether a call can fail on a full disk."""
    return call.writes and call.name not in FREE


def fails(call: Call) -> bool:
    """Whether a call can fail on a bad disk or network: any can."""
    return True


DISTURBANCES = {
    "killed": Disturbance(None, writes),
    "power lost": Disturbance(None, writes, torn=True),
    "input/output error": Disturbance(errno.EIO, fails),
    "stale handle": Disturbance(errno.ESTALE, fails),
    "permission denied": Disturbance(errno.EACCES, fails),
    "disk full from then on": Disturbance(errno.ENOSPC, takes_space, lasting=True),
}


@dataclass
class Trial:
    """A fault at one call of a run.

    at         index of the call
    seen       number of calls so far
    struck     the call that was disturbed; None before
    unflushed  paths of files whose bytes may not be on disk
    """

    disturbance: Disturbance
    processes: Processes
    at: int
    seen: int = 0
    struck: Call | None = None
    unflushed: set[str] = field(default_factory=set)

    def before(self, call: Call) -> None:
        """Disturb a call, or let it pass."""
        self.processes.check()
        later = self.disturbance.lasting and self.seen > self.at and self.disturbance.kinds(call)
        strikes = later or self.seen == self.at
        self.seen += 1
        if strikes:
            self.struck = self.struck or call
            if self.disturbance.number is None:
                self.processes.kill()
            raise OSError(self.disturbance.number, os.strerror(self.disturbance.number or 0), call.path)
        self._note(call)

    def _note(self, call: Call) -> None:
        if call.name == "fsync":
            self.unflushed.discard(call.path)
        elif call.writes and call.name in CONTENT:
            self.unflushed.add(call.path)
        elif call.target is not None:
            self.unflushed.discard(call.target)
            if call.path in self.unflushed:
                self.unflushed.add(call.target)


class Ending(NamedTuple):
    """How a run ended: a way, and its message."""

    way: str
    message: str = ""


class Scene:
    """A toy shot, its store, and its published files, in a folder in memory where there is one."""

    def __init__(self, folder: Path, processes: Processes, frames: int = FRAMES) -> None:
        self.shot = ToyShot(folder / "shot", frames)
        for source in (folder / "shot").rglob("*.py"):
            os.utime(source, (0.0, 0.0))
        self.store = folder / "store"
        self.processes = processes

    def clear(self) -> None:
        """Remove what runs have left."""
        for folder in (self.store, self.shot.out):
            shutil.rmtree(folder, ignore_errors=True)
        self.shot.tally()

    def run(self, before: Callable[[Call], None]) -> Ending:
        """Run the shot in a new process."""
        with patch.dict(SOURCES, clear=True), FileLayer((self.store, self.shot.out), before):
            return self.run_in_thread()

    def run_in_thread(self) -> Ending:
        """Run the shot in a new process of this thread."""
        self.processes.begin()
        try:
            outcome = run(load_graph(self.shot.graph), Store(self.store), options=Options(jobs=1))
        except Killed:
            return Ending("killed")
        except BadInput as error:
            return Ending(REFUSED, str(error))
        except Exception as error:
            return Ending(EXCEPTION, f"{type(error).__name__}: {error}")
        finally:
            self.processes.end()
        return Ending(FAILED if outcome.exit_code else "", "; ".join(map(str, outcome.failures)))


def try_calls(echo: Echo, check_value: CheckValue, every: int = 1) -> Report:
    """Try every disturbance at every n-th call of a run."""
    with tempfile.TemporaryDirectory(prefix="hairpipe-calls-", dir=MEMORY) as name:
        processes = Processes()
        scene = Scene(Path(name).resolve(), processes)
        with simulated(processes), patch.dict(os.environ, scene.shot.variables):
            calls, truth = undisturbed(scene, check_value)
            echo(f"a run makes {len(calls)} calls, {sum(call.writes for call in calls)} of which write")
            cases: list[Case] = []
            violations: list[Case] = []
            for title, disturbance in DISTURBANCES.items():
                places = [i for i, call in enumerate(calls) if disturbance.kinds(call)][::every]
                trials = [try_call(scene, disturbance, at, truth, check_value) for at in places]
                found = [trial for trial in trials if trial["violation"]]
                cases.append(summary(title, trials))
                violations += [{"disturbance": title, **trial} for trial in found]
                echo(f"{title}: {len(trials)} trials, {len(found)} violations")
    return make_report(__name__, {"calls": count_calls(calls), "disturbances": cases, "violations": violations})


def held(report: Report) -> bool:
    """Whether there is no violation."""
    return "violations" not in report.tables


def undisturbed(scene: Scene, check_value: CheckValue) -> tuple[list[Call], Truth]:
    """Run the shot; the calls, and what it left. BadInput where that fails, or where runs make different calls."""
    lists: list[list[Call]] = []
    for _ in range(3):  # the first one imports modules
        scene.clear()
        lists.append([])
        ending = scene.run(lists[-1].append)
        if ending.way:
            raise BadInput(f"the shot itself fails: {ending}", where=scene.shot.graph)
    names = [[call.name for call in calls] for calls in lists[1:]]
    if names[0] != names[1]:
        raise BadInput("undisturbed runs make different calls", where=scene.shot.graph)
    return lists[-1], Truth(state_of(scene.store, scene.shot.out, check_value), scene.shot.count())


def try_call(scene: Scene, disturbance: Disturbance, at: int, truth: Truth, check_value: CheckValue) -> Case:
    """Disturb a call of a run, and run again."""
    scene.clear()
    trial = Trial(disturbance, scene.processes, at)
    ending = scene.run(trial.before)
    if disturbance.torn:
        tear(scene, trial.unflushed)
    violations = list(violations_of(ending))
    if not ending.way:
        violations += differences(state_of(scene.store, scene.shot.out, check_value), truth.state)
    again = scene.run(lambda call: None)
    if again.way:
        violations.append(f"the next run: {again.way}: {again.message}")
    extra = scene.shot.count() - truth.evaluations
    if not 0 <= extra <= LOST:
        violations.append(f"{extra} evaluations more than undisturbed")
    violations += [
        f"next: {text}" for text in differences(state_of(scene.store, scene.shot.out, check_value), truth.state)
    ]
    violations += [f"{path.parent.name}/{path.name} is left" for path in left_over(scene)]
    struck = trial.struck or Call("none", "", False)
    return {
        "call": at,
        "name": struck.name,
        "path": struck.path,
        "ending": ending.way,
        "message": ending.message,
        "evaluated again": extra,
        "violation": "; ".join(violations),
    }


def violations_of(ending: Ending) -> Iterator[str]:
    """List what may not be in the ending of a disturbed run."""
    if ending.way == EXCEPTION:
        yield f"an exception in place of a message: {ending.message}"
    if "\n" in ending.message:
        yield "a message of several lines"


def left_over(scene: Scene) -> list[Path]:
    """Find temporary files and leases, which nobody holds any more.

    A process that ends between the creation of a lease and the next call leaves a file without a name. Nobody knows
    whose it is, so that it and those of the same key may stay for a day.
    """
    leases = [lease for path in (scene.store / "lease").glob("*") if (lease := read_lease(path)) is not None]
    unknown = {lease.path.name[:KEY] for lease in leases if not lease.name}
    temporary = [path for folder in (scene.store / "tmp", scene.shot.out) for path in folder.glob(".*")]
    return [*temporary, *(lease.path for lease in leases if lease.path.name[:KEY] not in unknown)]


def tear(scene: Scene, paths: set[str]) -> None:
    """Cut off the second half of files that were not flushed when the power failed."""
    for path in paths:
        for folder in (scene.store, scene.shot.out):
            with suppress(OSError):
                os.truncate(folder / path, (folder / path).stat().st_size // 2)


def summary(title: str, trials: list[Case]) -> Case:
    """Sum up the trials of a disturbance."""
    ways = [trial["ending"] for trial in trials]
    return {
        "disturbance": title,
        "trials": len(trials),
        "no effect": ways.count(""),
        "killed": ways.count("killed"),
        "failed with a message": ways.count(FAILED) + ways.count(REFUSED),
        "evaluated again at most": max(int(trial["evaluated again"] or 0) for trial in trials),
        "violations": sum(trial["violation"] != "" for trial in trials),
    }


def count_calls(calls: list[Call]) -> list[Case]:
    """Count the calls of an undisturbed run by function."""
    counts = Counter((call.name, call.writes) for call in calls)
    return [
        {"function": name, "writes": str(writes), "calls": count} for (name, writes), count in sorted(counts.items())
    ]
