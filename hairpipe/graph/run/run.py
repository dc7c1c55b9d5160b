"""Carries out a graph."""

from collections.abc import Iterable

from hairpipe.errors import BadInput
from hairpipe.graph.file.graph import Graph
from hairpipe.graph.run.events import Options, Outcome, Report
from hairpipe.graph.run.scheduler import Scheduler
from hairpipe.graph.store.store import Store


def run(
    graph: Graph,
    store: Store,
    frames: Iterable[int] | None = None,
    options: Options | None = None,
    report: Report = lambda event: None,
) -> Outcome:
    """Establish all nodes of a graph at these frames (all for None), publish files, thin the states of scans.

    A scan is evaluated from the first frame of the graph on, whatever is selected. Cut the graph with `graph.upto` to
    stop at a node. Raises BadInput before anything is evaluated; a failure of a node is part of the outcome. Ctrl-C
    stops the workers at once and gives the outcome so far: every result that was complete is kept.
    """
    numbers = graph.select(frames)
    try:
        store.sweep()
        return Scheduler(graph, store, numbers, options or Options(), report).carry_out()
    except OSError as error:
        raise BadInput(f"the store cannot be used: {error}", where=store.root) from None
