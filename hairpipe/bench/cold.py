"""How long compiling takes with nothing warm: two frames of the demo by a fresh process that has no kernels yet."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

_RUN = (sys.executable, "-c", "from hairpipe.cli import main; main()", "run", "demo", "-q", "-j1", "--to", "hair")
_SHORT = ("--frames", "1001-1002", "--set", "groom.strands=8")


def measure_compilation() -> float:
    """Find the time to compile every kernel from groom to hair, body and level set too [s].

    The same run, with an empty cache for results each time, first without kernels and then with those it left.
    """
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"NUMBA_CACHE_DIR": str(Path(folder, "kernels"))}
        times = []
        for cache in ("first", "second"):
            begun = time.perf_counter()
            subprocess.run([*_RUN, *_SHORT, "--cache", str(Path(folder, cache))], env=environment, check=True)
            times.append(time.perf_counter() - begun)
    return times[0] - times[1]
