"""Bytes that a simulation moves through the store, and the number of simulations that a network link carries."""

import tempfile
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from statistics import fmean, median
from typing import Any

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan.planner import Planner
from hairpipe.engine.run.events import Event
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Record, Store
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.machine import this_machine
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

HAIR = "hair"
"""Name of the scan in our graphs."""
GIGABIT = 125e6
"""Of a link [bytes/s]."""


def measure_traffic(echo: Echo, graphs: Mapping[str, Path], overrides: Mapping[str, str], node: str = HAIR) -> Report:
    """Measure a scan of each graph over the frames up to its first checkpoint, in a temporary store.

    BadInput where the node is not a scan, or a run fails.
    """
    cases = list[Case]()
    for name, path in graphs.items():
        echo(name)
        cases.append({"graph": name, **measure_scan(path, overrides, node)})
    return make_report(__name__, {"traffic": cases})


def measure_scan(path: Path, overrides: Mapping[str, str], node: str) -> Case:
    """Measure bytes and processor seconds of a frame of a scan, by the median: the first frames may compile."""
    graph = load_graph(path, overrides).upto([node])
    scan = graph.nodes[node]
    if scan.type.state is None:
        raise BadInput(f"'{node}' is not a scan from frame to frame", where=path, right="a scan")
    frames = range(graph.frames[0], graph.begin + scan.checkpoint)
    with tempfile.TemporaryDirectory() as folder:
        store = Store(Path(folder))
        seen = set[str]()

        def look(event: Event) -> None:
            if event.kind == "finished" and event.task is not None and event.task.node == node:
                seen.update(store.object_names())

        outcome = run(graph, store, frames, report=look)
        if outcome.interrupted:
            raise KeyboardInterrupt
        if outcome.failures:
            raise BadInput(f"'{node}' cannot be measured: {outcome.failures[0]}", where=path)
        planner = Planner(graph, store, frames)
        planner.entries()
        records = [record for task, record in planner.resolver.results.items() if task.node == node]
        sizes = {name: size or 0 for name in seen for size in [store.size(name)]}
        return traffic_of(records, seen, sizes, this_machine().cores)


def traffic_of(records: list[Record], seen: set[str], sizes: Mapping[str, int], cores: int) -> Case:
    """Return what the frames of a scan write and read on average, and the number of scans on a link; pure.

    A frame takes at least its processor seconds divided by the cores; other load on the machine does not change these.

    seen   names of the objects that were written
    sizes  of the objects that are read [bytes]
    """
    every = fmean(record.size for record in records)
    written = fmean(sum(size for name, size in record.objects() if name in seen) for record in records)
    inputs = [set(inputs_of(record)) for record in records]
    read = fmean(sum(sizes.get(name, 0) for name in new - old) for old, new in pairwise(inputs))
    processor = median(record.processor or record.seconds for record in records)
    simulations = GIGABIT * processor / cores / max(written, read)
    return {
        "frames": len(records),
        "processor [s]": processor,
        "written with every state [MB]": 1e-6 * every,
        "written [MB]": 1e-6 * written,
        "read [MB]": 1e-6 * read,
        "simulations on 1 Gbit/s": simulations,
        "simulations on 10 Gbit/s": 10.0 * simulations,
    }


def inputs_of(record: Record) -> Iterator[str]:
    """Name the objects that a frame of a scan reads, without the state that it starts from."""
    pending: list[Any] = [found for plug, found in record.parts["inputs"].items() if plug != "previous"]
    while pending:
        found = pending.pop()
        if isinstance(found, list):
            pending.extend(found)
        elif isinstance(found, str):
            yield found
