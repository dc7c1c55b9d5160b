"""Laws for every graph file in the house."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hairpipe.graph.fetch import fetch
from hairpipe.graph.graph import Graph
from hairpipe.graph.load import load_graph
from hairpipe.graph.plan import plan
from hairpipe.graph.run import run
from hairpipe.graph.store import Store
from hairpipe.graph.tasks import Task, unroll
from hairpipe.levelset.field import field_of
from hairpipe.levelset.sample import distance

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


FEW = {"groom.strands": "24", "picture.width": "64", "picture.height": "64"}
FIRST = 3
"""Frames of every graph that are computed."""
DEEPEST = 5e-3
"""How far inside a point may still be after three frames: imported strands that begin inside come out softly [m]."""


@pytest.fixture(scope="module")
def store(tmp_path_factory) -> Store:
    """One store for all graphs: kernels are compiled once."""
    return Store(tmp_path_factory.mktemp("graphs") / "cache")


def test_it_runs_and_no_hair_is_in_the_body(graph, store, tmp_path):
    short = load_graph(graph.path, FEW)
    elsewhere = {name: replace(n, publish=n.publish and tmp_path / n.publish.name) for name, n in short.nodes.items()}
    short = replace(short, nodes=elsewhere)
    frames = range(short.frames[0], short.frames[0] + FIRST)
    outcome = run(short, store, frames)
    assert not outcome.failures and outcome.exit_code == 0
    strands = fetch(short, store, Task("hair", frames[-1]), "strands")
    surface = field_of(fetch(short, store, Task("surface", frames[-1])))
    assert len(strands.offsets) - 1 <= 24
    assert np.isfinite(strands.points).all() and np.abs(strands.velocities).max() < 50
    free = np.delete(strands.points.astype(float), strands.offsets[:-1], axis=0)
    assert min(distance(surface, *point) for point in free) > -DEEPEST
