"""A Dask scheduler and one worker on this machine, as child processes that end with their parent."""

import importlib.util
import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from hairpipe.child import command, environment
from hairpipe.errors import BadInput

PATIENCE = 30.0
"""Maximum time until the scheduler has started [s]."""
LOOPBACK = ["--host", "127.0.0.1", "--no-dashboard"]
_BOOT = """from hairpipe.child import die_with_parent; die_with_parent()
from distributed.cli.dask_{} import main; sys.argv[1:] = {!r}; main()"""


@contextmanager
def dask_cluster(jobs: int) -> Iterator[str]:
    """Start a cluster, and kill it at the end; BadInput if Dask is absent or does not start.

    jobs  number of narrow slots of the worker, next to a wide one

    Yields the address of the scheduler.
    """
    if importlib.util.find_spec("distributed") is None:
        raise BadInput("Dask is not installed", right="pip install 'hairpipe[dask]'")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "scheduler.json")
        place = ["--scheduler-file", str(file)]
        slots = ["--nthreads", str(jobs + 1), "--resources", f"wide=1 narrow={jobs}"]
        limits = ["--no-nanny", "--memory-limit", "0", "--local-directory", folder]
        started = [start("scheduler", ["--port", "0", *place, *LOOPBACK])]
        started.append(start("worker", [*place, *slots, *limits, *LOOPBACK]))
        try:
            yield address_in(file)
        finally:
            for process in started:
                process.kill()
                process.wait()


def start(part: str, words: list[str]) -> "subprocess.Popen[bytes]":
    """Start a scheduler or a worker with this command line."""
    nowhere = subprocess.DEVNULL
    return subprocess.Popen(command(_BOOT.format(part, words)), env=environment(), stdout=nowhere, stderr=nowhere)


def address_in(file: Path) -> str:
    """Wait for the address that a scheduler writes to a file; BadInput if there is none."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            return json.loads(file.read_text(encoding="utf-8"))["address"]
        except (OSError, ValueError):  # absent, or half written
            time.sleep(0.1)
    raise BadInput("no Dask scheduler starts", right="`dask scheduler --host 127.0.0.1` to start: it names the fault")
