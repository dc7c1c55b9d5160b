"""Processor seconds of the first frame of a worker, with compiled kernels and stored inputs."""

import builtins
import json
import os
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hairpipe.child import command
from hairpipe.engine.code import CodeReader
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.hosts.host import environment
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker import machine_code
from hairpipe.engine.worker.machine_code import claim_kernels, kernels_environment, kernels_parent
from hairpipe.graphs.experiments.bench.replay import Replay
from hairpipe.graphs.experiments.bench.report import Report, make_report

HAIR = "hair"
"""Name of the scan in our graphs."""
PYTHON, NUMBA, IMPORTS = "start Python, import the engine", "import numba", "import other modules"
GRAPH = "read the graph, which the coordinator does in a run"
READING, DIGESTS, LOADING = "read inputs", "check digests of kernels", "load kernels"
COMPUTING, SECOND, COMPILED = (
    "build the model, compute the frame",
    "the frame after it",
    "keep kernels compiled by then",
)
_BOOT = f"from {__name__} import report_phases; report_phases({{!r}}, {{!r}}, {{!r}}, {{!r}})"


class Clock:
    """Processor seconds by phase, without those of inner phases."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._inner = [0.0]

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the time of a context to a phase."""
        begun = time.process_time()
        self._inner.append(0.0)
        try:
            yield
        finally:
            spent = time.process_time() - begun
            self.seconds[name] += spent - self._inner.pop()
            self._inner[-1] += spent

    def counted(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Wrap a function, whose calls are a phase."""

        def call(*args: Any, **named: Any) -> Any:
            with self.phase(name):
                return function(*args, **named)

        return call


def measure_first_frame(graph_path: Path, overrides: Mapping[str, str], node: str = HAIR) -> Report:
    """Measure the first frames of a scan of a graph in a new process, by phase, after another has compiled all kernels.

    Raises BadInput if the node is not a scan, or one of its inputs fails.
    """
    graph = load_graph(graph_path, overrides)
    modules = [node.type.module for node in graph.nodes.values()]
    kernels = kernels_environment(claim_kernels(kernels_parent()), CodeReader(lambda name, make: make()), modules)
    with tempfile.TemporaryDirectory() as folder:
        Replay(graph, Store(Path(folder)), node).prepare(2)
        code = _BOOT.format(str(graph_path), dict(overrides), folder, node)
        _, warm = (measured(code, kernels) for _ in range(2))
    return make_report(__name__, {"phases": [{"phase": name, "processor [s]": spent} for name, spent in warm.items()]})


def measured(code: str, kernels: dict[str, str]) -> dict[str, float]:
    """Return the output of this code in a new process with these kernels."""
    done = subprocess.run(command(code), env=environment(1, kernels), check=True, stdout=subprocess.PIPE)
    return json.loads(done.stdout)


def report_phases(graph_path: str, overrides: dict[str, str], store: str, node: str) -> None:
    """Compute two frames in this process, and print processor seconds by phase as JSON."""
    clock = Clock()
    clock.seconds[PYTHON] = time.process_time()
    machine_code.is_there = clock.counted(DIGESTS, machine_code.is_there)
    machine_code.guard_kernels()
    with clock.phase(NUMBA):
        import numba  # noqa: F401
        from numba.core import caching
    caching.Cache.load_overload = clock.counted(LOADING, caching.Cache.load_overload)
    caching.Cache.save_overload = clock.counted(COMPILED, caching.Cache.save_overload)
    with clock.phase(GRAPH):
        replay = Replay(load_graph(Path(graph_path), overrides), Store(Path(store)), node)
    builtins.__import__ = clock.counted(IMPORTS, builtins.__import__)
    for computing, reading in ((COMPUTING, READING), (SECOND, SECOND)):
        with clock.phase(reading):
            arguments = replay.arguments()
        with clock.phase(computing):
            replay.advance(arguments)
    os.write(1, json.dumps(clock.seconds).encode())
