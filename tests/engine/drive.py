"""Runs a graph in a process of its own, for tests that kill it: graph, store, jobs; the outcome as JSON.

TOY_MACHINE names the machine that it pretends to run on.
"""

import json
import os
import sys
from dataclasses import asdict
from pathlib import Path

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store import holder
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker import machine_code

if __name__ == "__main__":
    machine_code.kernel_modules = lambda: iter(())  # as in the shot of tests: no toy calls a kernel of ours
    if "TOY_MACHINE" in os.environ:
        holder.machine = lambda: f"{os.environ['TOY_MACHINE']:0>12}"
    graph, store, jobs = sys.argv[1:4]
    outcome = run(load_graph(Path(graph)), Store(Path(store)), options=Options(jobs=int(jobs)))
    print(json.dumps(asdict(outcome)))
    sys.exit(outcome.exit_code)
