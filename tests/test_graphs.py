"""Laws for every graph file in the house."""

from pathlib import Path

import pytest

from hairpipe.graph.graph import Graph
from hairpipe.graph.load import load_graph
from hairpipe.graph.plan import plan
from hairpipe.graph.store import Store
from hairpipe.graph.tasks import unroll

HOME = Path(__file__).resolve().parents[1]
GRAPHS = sorted((HOME / "graphs").rglob("*.toml"))


def name_of(path: Path) -> str:
    return path.relative_to(HOME / "graphs").as_posix()


@pytest.fixture(params=GRAPHS, ids=name_of)
def graph(request: pytest.FixtureRequest) -> Graph:
    """Each graph in turn; those that read third-party data are left out where that is absent."""
    if "shared/data" in request.param.read_text(encoding="utf-8"):
        request.getfixturevalue("shared")
    return load_graph(request.param)


def test_the_demo_is_there():
    assert HOME / "graphs" / "demo.toml" in GRAPHS


def test_it_can_be_planned(graph, tmp_path):
    entries = plan(graph, Store(tmp_path / "cache"))
    assert [entry.task for entry in entries] == list(unroll(graph, graph.select(None)))
    assert entries[0].status == "run" and all(entry.status != "cached" for entry in entries)
    assert not (tmp_path / "cache").exists()


def test_it_publishes_something_and_only_below_out(graph):
    published = [node.publish for node in graph.nodes.values() if node.publish]
    assert published and all(path.is_relative_to(HOME / "out") for path in published)
