"""Compilation ahead of the first run: the first frames of a graph, computed in a temporary folder and discarded."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from hairpipe.api.shot import Shot, load
from hairpipe.api.source import shipped_graphs
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.worker.machine_code import kernels_parent

FRAMES = 2
"""Number of computed frames: the first of a simulation is its start, and the second its first step."""
NOTICE = "kernels are compiled, once, in about a minute (`hairpipe warm` compiles them ahead)"
OURS = "hairpipe.nodes."


def shots_to_warm() -> list[str]:
    """List the shipped graphs that are shots: those that are in no folder of examples or experiments."""
    return [name for name in shipped_graphs() if "/" not in name]


@contextmanager
def warming(shot: Shot) -> Iterator[tuple[Shot, list[int]]]:
    """Yield the shot without published files, in a temporary folder of results, and the frames to run."""
    tables = {
        name: {key: value for key, value in table.items() if key != "publish"} if isinstance(table, dict) else table
        for name, table in shot.tables.items()
    }
    begin = shot.graph.begin
    with tempfile.TemporaryDirectory(prefix="hairpipe-") as folder:
        yield (
            load(tables, cache=folder, folder=shot.path.parent),
            list(range(begin, min(begin + FRAMES, shot.graph.frames[1] + 1))),
        )


def compiles_first(graph: Graph) -> bool:
    """Whether a run of a graph compiles kernels since this user has none: it has nodes of the house."""
    with suppress(OSError):  # no home: kernels are not kept
        if next(kernels_parent().glob("*/*.nbc"), None) is not None:
            return False
    return any(node.type.module.startswith(OURS) for node in graph.nodes.values())
