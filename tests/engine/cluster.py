"""A Dask cluster for tests: a scheduler and two workers on loopback, each with a home of its own."""

import os
import subprocess
import sys

from .conftest import wait_for

WORKER = """from hairpipe.engine.worker import machine_code
machine_code.kernel_modules = lambda: iter(())
from distributed.cli.dask_worker import main
main()"""
SCHEDULER = "from distributed.cli.dask_scheduler import main; main()"


class Cluster:
    """A scheduler and its workers, as processes."""

    def __init__(self, folder) -> None:
        self.folder = folder
        self.processes = {}
        self.file = folder / "scheduler.json"
        self.start("scheduler", SCHEDULER, "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(self.file))
        wait_for(self.file.exists)
        wait_for(lambda: "tcp://" in self.file.read_text())
        self.address = self.file.read_text().split('"address": "')[1].split('"')[0]
        for name in ("one", "two"):
            self.worker(name)
        logs = [folder / name / "log" for name in ("one", "two")]
        wait_for(lambda: all("Registered to" in log.read_text() for log in logs))

    def start(self, name, code, *arguments) -> None:
        """Start a process of the cluster."""
        home = self.folder / name
        home.mkdir()
        told = {"HOME": str(home), "TMPDIR": str(home), "XDG_CACHE_HOME": str(home), "XDG_CONFIG_HOME": str(home)}
        environment = {key: value for key, value in os.environ.items() if key != "HAIRPIPE_TRUST"} | told
        command = [sys.executable, "-c", code, *arguments, "--no-dashboard"]
        log = (home / "log").open("w")
        self.processes[name] = subprocess.Popen(command, cwd=home, env=environment, stdout=log, stderr=log)

    def worker(self, name) -> None:
        """Start a worker with slots for one wide job and two narrow ones."""
        numbers = ["--nthreads", "3", "--no-nanny", "--memory-limit", "0", "--resources", "wide=1 narrow=2"]
        self.start(name, WORKER, self.address, "--host", "127.0.0.1", "--name", name, *numbers)

    def close(self) -> None:
        """Kill all processes."""
        for process in self.processes.values():
            process.kill()
            process.wait()
