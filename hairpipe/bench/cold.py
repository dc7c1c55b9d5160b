"""Time to compile from a cold cache: two frames of the demo by a fresh process that has no kernels yet."""

import subprocess
import tempfile
import time
from pathlib import Path

from hairpipe.child import command, environment

_RUN = ("run", "demo", "-q", "-j1", "--to", "hair", "--frames", "1001-1002", "--set", "groom.strands=8")
_MAIN = "from hairpipe.cli import main; sys.argv[1:] = {!r}; main()"


def measure_compilation() -> float:
    """Find the time to compile every kernel from groom to hair, body and level set too [s].

    The same run, with an empty cache for results each time, first without kernels and then with those it left.
    """
    with tempfile.TemporaryDirectory() as folder:
        kernels = environment() | {"NUMBA_CACHE_DIR": str(Path(folder, "kernels"))}
        times = []
        for cache in ("first", "second"):
            begun = time.perf_counter()
            words = [*_RUN, "--cache", str(Path(folder, cache))]
            subprocess.run(command(_MAIN.format(words)), env=kernels, check=True)
            times.append(time.perf_counter() - begun)
    return times[0] - times[1]
