"""Faults that strike while several machines compute a shot, as a list: what, when, and what it may cost."""

import signal
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

from hairpipe.graphs.experiments.bench.machines.processes import Machine
from hairpipe.graphs.experiments.bench.machines.scene import ELSEWHERE, HOSTS, Engine, Part, Scene, machine

Act = Callable[[Scene], None]
"""Does harm, opens the gate, and waits for what it has started."""
SOON = 4.0
"""Pause after which a stopped process goes on, before anybody has given it up [s]."""
FIRST, FRAME, STEP, FILE = "make_seed None", "move_seed 3", "add_up 4", "write_list None"
"""Evaluations that are held: the value for the shot, a frame, a frame of a scan, the file of all frames."""
MOMENTS = {FIRST: "first value", FRAME: "a frame", STEP: "frame of a scan", FILE: "file of all frames", "": "the run"}
UNWRITTEN = {FIRST: 0, FRAME: 2, STEP: 0, FILE: 0}
"""Number of frames of the scan that are lost with a process: their states are only in its memory before the first
checkpoint, frame 3.
"""


class Fault(NamedTuple):
    """A fault.

    what    happens
    during  line of the evaluation that is held until it has happened; empty: nothing is held
    act     does it
    lost    number of evaluations that may be lost
    code    exit code of the run; negative: the number of the signal that ends it
    lines   number of lines that the run may write
    hosts   machines of the Dask cluster; None: two, where the engine is Dask
    nanny   whether Dask starts its workers again
    disk    whether the store has a small file system of its own
    again   engine of the run that completes the shot; None for the same
    """

    what: str
    engine: Engine
    during: str
    act: Act
    lost: int = 0
    code: int = 0
    lines: int = 0
    hosts: tuple[Machine, ...] | None = None
    nanny: bool = False
    disk: bool = False
    again: Engine | None = None

    @property
    def title(self) -> str:
        """What happens, where and when, in a few words."""
        return f"{self.engine}, {MOMENTS[self.during]}: {self.what}"

    def scene(self, folder: Path) -> Scene:
        """Make the scene in a folder; OSError where this process may not mount a file system."""
        hosts = self.hosts if self.hosts is not None else HOSTS if self.engine == "dask" else ()
        return Scene(folder, self.engine, hosts, nanny=self.nanny, disk=self.disk)


def do_nothing(scene: Scene) -> None:
    """Only let the evaluation go on."""
    scene.shot.open_gate()


def kill(part: Part, scene: Scene) -> None:
    """Kill a part."""
    scene.send(part, signal.SIGKILL)
    scene.shot.open_gate()


def stop(part: Part, scene: Scene, pause: float = SOON) -> None:
    """Stop a part for a time [s]."""
    scene.send(part, signal.SIGSTOP)
    scene.shot.open_gate()
    time.sleep(pause)
    scene.send(part, signal.SIGCONT)


def outlast(part: Part, scene: Scene) -> None:
    """Stop a part until the run has ended, let it finish what it was doing, and run once more.

    A machine that was slow stores the state of its frame, which the run has removed since; the next one removes it.
    """
    scene.send(part, signal.SIGSTOP)
    scene.shot.open_gate()
    scene.runs[0].wait()
    with suppress(ProcessLookupError):
        scene.send(part, signal.SIGCONT)
    time.sleep(SOON)
    scene.start("local").wait()


def overtake(scene: Scene) -> None:
    """Stop the machine of the run until the run of another machine has ended."""
    scene.send("machine", signal.SIGSTOP)
    scene.shot.open_gate()
    scene.start("local", ELSEWHERE).wait()
    scene.send("machine", signal.SIGCONT)


def join(engine: Engine, other: Machine, scene: Scene) -> None:
    """Start a second run."""
    second = scene.start(engine, other)
    time.sleep(SOON)
    scene.shot.open_gate()
    second.wait()


def kill_and_join(engine: Engine, scene: Scene) -> None:
    """Start a second run on another machine, and kill the machine of the first."""
    second = scene.start(engine, ELSEWHERE)
    time.sleep(SOON)
    scene.send("machine", signal.SIGKILL)
    scene.shot.open_gate()
    second.wait()


def fill_disk(scene: Scene) -> None:
    """Fill the file system of the store until the run has ended."""
    filler = scene.store / "filler"
    with suppress(OSError), filler.open("wb", buffering=0) as file:
        while True:
            file.write(bytes(4096))
    scene.shot.open_gate()
    scene.runs[0].wait()
    filler.unlink()


OTHER_VERSIONS = "from hairpipe.engine.hosts import offer\noffer.VERSIONS = 'hairpipe 99.0, Python 3.11'"
OTHER_STORE = "from hairpipe.engine.hosts import offer\noffer.identity_of = lambda root: '0' * 32"
OTHER_NUMPY = """from hairpipe.engine.key import code
own = code.version
code.version = lambda name: "99.0" if name == "numpy" else own(name)"""
OTHER_CODE = """import importlib.util, os, shutil
package = importlib.util.find_spec("hairpipe").submodule_search_locations[0]
shutil.copytree(package, "hairpipe", ignore=shutil.ignore_patterns("__pycache__"))
with open("hairpipe/errors.py", "a") as file:
    file.write("OTHER = 1")
sys.path.insert(0, os.getcwd())"""
"""Prelude of a machine with a checkout of its own, in which a module behind all nodes differs."""
OTHER_CLASS = {"NPY_DISABLE_CPU_FEATURES": "AVX2"}
STALE = """import os, pathlib, time
stat, opened, replace, missed = pathlib.Path.stat, os.open, pathlib.Path.replace, {}
def stale(path, **words):
    known = f"{os.sep}actions{os.sep}" in str(path)
    if known and time.monotonic() - missed.get(str(path), -60.0) < 30.0:
        raise FileNotFoundError(2, "not there when last looked", str(path))
    try:
        return stat(path, **words)
    except FileNotFoundError:
        missed[str(path)] = time.monotonic()
        raise
def refresh(path, *words, **named):
    for name in [name for name in missed if os.path.dirname(name) == str(path)]:
        del missed[name]
    return opened(path, *words, **named)
def renew(path, target):
    missed.pop(str(target), None)
    return replace(path, target)
pathlib.Path.stat, os.open, pathlib.Path.replace = stale, refresh, renew"""
"""A client of NFS: a name that was not there is not asked for again for 30 s, unless its folder is opened."""
HEALTHY = HOSTS[0]


def one_other(what: str, prelude: str = "", **variables: str) -> Fault:
    """Make the fault that one of two machines of a cluster has something else."""
    hosts = (HEALTHY, machine("e", prelude, **variables))
    return Fault(f"one machine has {what}", "dask", "", do_nothing, lines=1, hosts=hosts)


FAULTS = (
    *(Fault("child killed", "local", moment, partial(kill, "child"), 1, 1, 2) for moment in MOMENTS if moment),
    Fault("child stopped for 4 s", "local", STEP, partial(stop, "child")),
    *(
        Fault("coordinator killed", "local", moment, partial(kill, "coordinator"), 1 + UNWRITTEN[moment], -9)
        for moment in (FIRST, FRAME, STEP, FILE)
    ),
    Fault("machine killed", "local", STEP, partial(kill, "machine"), 1, -9),
    Fault("coordinator stopped for 4 s", "local", STEP, partial(stop, "coordinator")),
    Fault("two runs on machines", "local", STEP, partial(join, "local", ELSEWHERE)),
    Fault("two runs, one with stale listings", "local", STEP, partial(join, "local", machine("b", STALE))),
    Fault("machine stopped until another has taken over", "local", STEP, overtake, 1),
    Fault("child killed", "dask", FRAME, partial(kill, "child"), 1, 0, 1),
    Fault("child killed", "dask", STEP, partial(kill, "child"), 1, 0, 1),
    Fault("child stopped for 4 s", "dask", STEP, partial(stop, "child")),
    *(Fault("Dask worker killed", "dask", moment, partial(kill, "host"), 1, 0, 1) for moment in MOMENTS if moment),
    Fault("Dask worker killed, with a nanny", "dask", STEP, partial(kill, "host"), 1, 0, 1, nanny=True),
    Fault("Dask worker stopped for 4 s", "dask", STEP, partial(stop, "host")),
    Fault("machine stopped until the end", "dask", STEP, partial(outlast, "machine"), 1, 0, 1),
    Fault("scheduler killed", "dask", STEP, partial(kill, "scheduler"), 1, 1, 2, again="local"),
    Fault("scheduler stopped for 4 s", "dask", STEP, partial(stop, "scheduler")),
    Fault("scheduler stopped until the end", "dask", STEP, partial(outlast, "scheduler"), 1, 1, 2, again="local"),
    Fault("coordinator killed", "dask", STEP, partial(kill, "coordinator"), 0, -9),
    Fault("coordinator killed, then a local run", "dask", STEP, partial(kill, "coordinator"), 0, -9, again="local"),
    Fault("coordinator stopped for 4 s", "dask", STEP, partial(stop, "coordinator")),
    Fault("a local run next to it", "dask", STEP, partial(join, "local", ELSEWHERE)),
    Fault("a run by Dask next to it", "local", STEP, partial(join, "dask", ELSEWHERE), hosts=HOSTS),
    Fault("machine killed, a run by Dask goes on", "local", STEP, partial(kill_and_join, "dask"), 1, -9, hosts=HOSTS),
    Fault("store full", "local", FRAME, fill_disk, 1 + UNWRITTEN[FRAME], 1, 2, disk=True),
    Fault("store full", "local", STEP, fill_disk, 1, 1, 2, disk=True),
    Fault("store full", "dask", STEP, fill_disk, 1, 1, 2, disk=True),
    one_other("other code", OTHER_CODE),
    one_other("another version of hairpipe", OTHER_VERSIONS),
    one_other("another numpy", OTHER_NUMPY),
    one_other("another class of processor", **OTHER_CLASS),
    one_other("another store", OTHER_STORE),
)
