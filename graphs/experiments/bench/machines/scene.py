"""The scene of a fault: a toy shot and its store, machines that compute it, and signals to their processes."""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Literal, Self

from hairpipe.graphs.experiments.bench.machines.cluster import Cluster
from hairpipe.graphs.experiments.bench.machines.processes import (
    NO_KERNELS,
    Machine,
    Started,
    start_command,
    wait_for,
)
from hairpipe.graphs.experiments.bench.toy_shot import ToyShot

Engine = Literal["local", "dask"]
Part = Literal["child", "host", "machine", "coordinator", "scheduler"]
"""Whom a signal is for: child: the process that evaluates; host: its parent, the coordinator or a Dask worker; machine:
the host with all its children.
"""
NAMED = "from hairpipe.engine.store import holder\nholder.machine = lambda: '{:0>12}'\n"
"""Prelude of a machine with a name of its own: it cannot look up the processes of others."""
CHILDREN = "from hairpipe.engine.hosts import host\nhost.BOOT = {!r} + host.BOOT"
"""Gives the workers of a machine the same prelude."""
SIZE = "96m"
"""Of the file system of a store [bytes]."""
QUIET = 1.0
"""Time without a new evaluation after which only the held one is in progress [s]."""


def machine(name: str, prelude: str = "", **variables: str) -> Machine:
    """Make a machine with a name of hexadecimal digits; pure."""
    named = NAMED.format(name)
    return Machine("\n".join(filter(None, (prelude, NO_KERNELS, named, CHILDREN.format(named)))), variables)


HERE = machine("a")
ELSEWHERE = machine("b")
HOSTS = (machine("c"), machine("d"))


class Scene:
    """A toy shot with an empty store, in a folder; a cluster for Dask.

    hosts  machines of the cluster; none: no cluster
    nanny  whether Dask starts its workers again
    disk   whether the store has a small file system of its own; OSError where this process may not mount one
    """

    def __init__(
        self, folder: Path, engine: Engine, hosts: tuple[Machine, ...], *, nanny: bool = False, disk: bool = False
    ) -> None:
        self.folder = folder
        self._disk = disk
        self.engine: Engine = engine
        self.shot = ToyShot(folder / "shot")
        self.store = folder / "store"
        if disk:
            mount_disk(self.store)
        self.cluster = Cluster(folder, hosts, self.shot.variables, nanny=nanny) if hosts else None
        self.runs: list[Started] = []

    def __enter__(self) -> Self:
        """Nothing else begins."""
        return self

    def __exit__(self, *error: object) -> None:
        """Kill all processes."""
        for run in self.runs:
            run.end()
        if self.cluster is not None:
            self.cluster.close()
        if self._disk:
            subprocess.run(["umount", "--lazy", self.store], check=False)
        shutil.rmtree(self.folder, ignore_errors=True)

    def start(self, engine: Engine | None = None, machine: Machine = HERE) -> Started:
        """Start a run of the shot, by the engine of the scene if no other is given."""
        words = ["run", str(self.shot.graph), "--cache", str(self.store), "-q", "-j", "2"]
        if (engine or self.engine) == "dask":
            assert self.cluster is not None
            words += ["--engine", "dask", "--scheduler", self.cluster.address, "--insecure"]
        home = self.folder / f"run-{len(self.runs)}"
        self.runs.append(start_command(words, home, machine, self.shot.variables))
        return self.runs[-1]

    def wait_for_gate(self) -> None:
        """Wait until an evaluation is held, and all others that do not need its result are complete."""
        wait_for(lambda: self.shot.held() or self.runs[0].process.poll() is not None, "the evaluation to hold")
        count = -1
        since = time.monotonic()
        while time.monotonic() - since < QUIET:
            time.sleep(0.1)
            if self.shot.count() != count:
                count = self.shot.count()
                since = time.monotonic()

    def send(self, part: Part, number: signal.Signals) -> None:
        """Send a signal to a part."""
        if part == "scheduler":
            assert self.cluster is not None
            os.kill(self.cluster.scheduler.process.pid, number)
        elif part == "coordinator":
            os.kill(self.runs[0].process.pid, number)
        else:
            held = self.shot.held()
            assert held is not None, "no evaluation is held"
            child, parent, group = held
            if part == "machine":
                os.killpg(group, number)
            else:
                os.kill(child if part == "child" else parent, number)


def mount_disk(folder: Path) -> None:
    """Mount an empty file system in memory; OSError where this process may not."""
    folder.mkdir(parents=True)
    words = ["mount", "-t", "tmpfs", "-o", f"size={SIZE},mode=700", "none", str(folder)]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        raise OSError(f"no file system for a full store: {done.stderr.strip()}")
