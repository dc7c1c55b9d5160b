"""A Dask cluster of several machines on loopback: a scheduler, and workers with homes of their own."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.machines.processes import Machine, Started, wait_for, without_trust

LOOPBACK = ("--host", "127.0.0.1", "--no-dashboard")
SLOTS = ("--nthreads", "3", "--resources", "wide=1 narrow=2", "--memory-limit", "0")
BOOT = "from distributed.cli.dask_{} import main; sys.argv[1:] = {!r}; main()"


class Cluster:
    """A scheduler and its workers, as processes.

    folder     for the homes
    machines   a worker on each
    variables  of the environment of the workers
    nanny      whether Dask starts a worker again that has ended
    words      of the command lines of all: certificates

    BadInput where Dask is absent or does not start.
    """

    def __init__(
        self,
        folder: Path,
        machines: Sequence[Machine],
        variables: Mapping[str, str],
        *,
        nanny: bool = False,
        words: Sequence[str] = (),
    ) -> None:
        file = folder / "scheduler.json"
        place = ["--port", "0", "--scheduler-file", str(file), *words, *LOOPBACK]
        self.scheduler = Started(BOOT.format("scheduler", place), folder / "scheduler", Machine(), {})
        self.workers: list[Started] = []
        try:
            wait_for(lambda: self.is_running(self.scheduler) and address_in(file), "the Dask scheduler")
            self.address = address_in(file)
            for number, machine in enumerate(machines):
                home = folder / f"worker-{number}"
                given = [self.address, "--name", f"worker-{number}", "--nanny" if nanny else "--no-nanny"]
                given += ["--local-directory", str(home), *SLOTS, *words, *LOOPBACK]
                code = BOOT.format("worker", given)
                self.workers.append(Started(code, home, machine, without_trust() | dict(variables)))
            wait_for(self.is_complete, "the Dask workers")
        except BaseException:
            self.close()
            raise

    @staticmethod
    def is_running(started: Started) -> bool:
        """Whether a process runs; BadInput where it has ended."""
        if started.process.poll() is not None:
            raise BadInput(f"Dask does not start: {started.text[-300:]}", right="pip install 'hairpipe[dask]'")
        return True

    def is_complete(self) -> bool:
        """Whether all workers are connected; BadInput where one has ended."""
        return all(self.is_running(worker) and "Registered to" in worker.text for worker in self.workers)

    def close(self) -> None:
        """Kill all processes."""
        for started in (*self.workers, self.scheduler):
            started.end()


def address_in(file: Path) -> str:
    """Read the address that a scheduler has written to a file; empty before it has."""
    try:
        return json.loads(file.read_text(encoding="utf-8"))["address"]
    except (OSError, ValueError):  # absent, or half written
        return ""
