"""Laws for every graph file in the house."""

import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import hairpipe
from hairpipe.engine.file.graph import Edge, Graph
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.hosts.host import Member
from hairpipe.engine.plan.planner import plan, read_result
from hairpipe.engine.plan.tasks import Task, unroll
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.levelset.sample import Field, distance, field_of
from hairpipe.values import Strands

from .graph_cover import cover
from .pages import data_of

HOME = Path(__file__).resolve().parents[1]
OUT = HOME / "out"
GRAPHS = sorted((HOME / "graphs").rglob("*.toml"))
WEDGED = [path for path in GRAPHS if "wedge" in tomllib.loads(path.read_text(encoding="utf-8"))]


def name_of(path: Path) -> str:
    return path.relative_to(HOME / "graphs").as_posix()


@pytest.fixture(params=GRAPHS, ids=name_of)
def graph(request: pytest.FixtureRequest) -> Graph:
    """Each graph in turn; those that read third-party data are left out where that is absent."""
    if data_of(request.param):
        request.getfixturevalue("third_party")
    return loaded(request.param)


@cache
def loaded(path: Path) -> Graph:
    """Load a graph once for all tests."""
    return load_graph(path)


def test_the_demo_is_there():
    assert HOME / "graphs" / "demo.toml" in GRAPHS


def test_it_can_be_planned(graph, tmp_path):
    entries = plan(graph, Store(tmp_path / "cache"))
    assert [entry.task for entry in entries] == list(unroll(graph, graph.select(None)))
    assert entries[0].status == "run" and all(entry.status != "cached" for entry in entries)
    assert not (tmp_path / "cache").exists()


def test_it_publishes_something_and_only_below_out(graph):
    published = [node.publish for node in graph.nodes.values() if node.publish]
    assert published and all(path.is_relative_to(OUT) for path in published)


@pytest.mark.parametrize("path", WEDGED, ids=name_of)
def test_its_wedges_are_of_variants_that_can_be_loaded(path):
    _, *wedges = hairpipe.load(path).graphs()
    assert wedges and all(merged.nodes for merged in wedges)


FEW: dict[str, dict[str, float | list[int] | list[float]]] = {
    "bake_levelset": {"voxel": 0.01},
    "bake_parts": {"voxel": 0.02},
    "grow_groom": {"strands": 24},
    "load_groom": {"strands": 24},
    "sample_particles": {"particles": 200},
    "thin_groom": {"every": 2},
    "compare_guides": {"every": [6]},
    "measure_cantilever": {"segments": [8], "angles": [90], "rolls": 1, "gammas": [1]},
    "measure_torsion": {"segments": [8], "twists": [1]},
    "measure_helix": {"segments": [25], "gravities": [0.1], "orientations": 1},
    "measure_spiral": {"segments": [25], "gravities": [0.1], "orientations": 1},
    "measure_vibration": {"segments": [8], "modes": 2},
    "measure_writhe": {"segments": [5]},
    "measure_column": {"segments": [5]},
    "measure_ring": {"segments": [8]},
    "measure_hanging": {"segments": [20], "weights": [30.0], "curvatures": [8.0], "helix": [8.0, 40.0]},
    "map_curls": {"segments": 20, "curvatures": [3.0], "weights": [5.0], "hooks": [30.0], "coils": [8.0]},
    "measure_balanced": {"segments": [25]},
    "measure_rub": {"speeds": [0.05], "shares": [0.5]},
    "measure_rates": {"rates": [24], "intervals": 1, "every": 1 / 24, "finer": 1},
    "measure_rest": {"seconds": 1 / 24},
    "measure_wrap": {"first": 0.0},
    "measure_pull": {"first": 0.0},
    "measure_knot": {"first": 0.0},
    "measure_plectoneme": {"first": 0.0},
    "measure_stack": {"layers": [2], "iterations": 5, "seconds": 0.01},
    "follow_trial": {"trial.seconds": 0.125, "rate": 240},
    "measure_interpolation": {"voxel": 0.2, "half_width": 2},
    "measure_clash": {"speeds": [4.0], "rates": [24], "seconds": 0.1},
    "measure_cloud_clash": {"speeds": [4.0], "rates": [24], "seconds": 0.1},
    "measure_scheme": {"trial.seconds": 0.125, "rates": [24]},
    "measure_extremes": {"rates": [24], "seconds": 0.05},
    "plot_interpolation": {"voxel": 0.2, "half_width": 2},
    "measure_fidelity": {"skip": 0},
    "measure_packing": {"skip": 0},
    "measure_cost": {"warm": 1, "timed": 1},
    "preview": {"width": 64, "height": 64},
    "preview_particles": {"width": 64, "height": 64},
    "preview_meshes": {"width": 64, "height": 64},
    "render_cycles": {"width": 64, "height": 64, "samples": 1},
}
"""Settings by node type with which every graph runs in a moment."""
FIRST = 2
"""Frames of every graph that are computed."""
LONGER = {"measure_lag"}
"""Node types that refuse so few frames: the head has not turned yet."""
DEEPEST = 1e-3
"""How far inside a point may be after them, of a strand that began outside: others come out softly [m]."""


@pytest.fixture(scope="session")
def chosen(find_data: Callable[[pytest.MonkeyPatch], bool]) -> dict[Path, list[str]]:
    """Nodes that are computed, by graph: with all they depend on they are of every kind that there is.

    Third-party data is read only for what nothing else shows.
    """
    ours = {path: shorten(path) for path in GRAPHS if not data_of(path)}
    with pytest.MonkeyPatch.context() as patch:
        there = find_data(patch)
        return cover(ours, {path: shorten(path) for path in GRAPHS if there and data_of(path)})


def sections() -> dict[str, list[Path]]:
    """Part the graphs into those that can be run as one: most of the time of each alone workers need to begin.

    Those of one section share their folder, by which files are found, their first frame and their frame rate.
    """
    alike: dict[tuple, list[Path]] = defaultdict(list)
    for path in GRAPHS:
        header = tomllib.loads(path.read_text(encoding="utf-8"))  # no file that it reads need be there
        alike[path.parent, header["frames"][0], header["fps"], bool(data_of(path))].append(path)
    return {f"{name_of(paths[0])} and {len(paths) - 1} more": paths for paths in alike.values()}


SECTIONS = sections()


@pytest.fixture(params=SECTIONS.values(), ids=list(SECTIONS))
def section(request: pytest.FixtureRequest, chosen: dict[Path, list[str]]) -> list[Graph]:
    """Each section in turn, of its graphs what was chosen."""
    if chosen.keys() & {path for path in request.param if data_of(path)}:
        request.getfixturevalue("third_party")
    graphs = [shorten(path).upto(chosen[path]) for path in request.param if path in chosen]
    return graphs or pytest.skip("others show all that these graphs do")


@pytest.fixture(scope="session")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """One store for all groups: many begin with the same head and groom."""
    return Store(tmp_path_factory.mktemp("graphs") / "cache")


@pytest.fixture(scope="session")
def spare() -> Iterator[list[Member]]:
    """Workers that go on from one group to the next."""
    members: list[Member] = []
    yield members
    for member in members:
        member.end()


def merged(graphs: list[Graph]) -> Graph:
    """One graph of several with few frames, the names of nodes after those of their graphs."""
    nodes, taken = {}, set()
    for graph in graphs:
        prefix = f"{graph.path.stem}-"
        for node in graph.nodes.values():
            edges = {plug: Edge(prefix + edge.node, edge.output) for plug, edge in node.edges.items()}
            nodes[prefix + node.name] = replace(node, name=prefix + node.name, edges=edges)
        taken |= {Edge(prefix + edge.node, edge.output) for edge in graph.taken}
    first = graphs[0].frames[0]
    return replace(graphs[0], frames=(first, first + FIRST - 1), nodes=nodes, taken=frozenset(taken))


def shorten(path: Path) -> Graph:
    """Load a graph with less to do in every frame, without nodes of `LONGER` or without their library."""
    graph = loaded(path)
    less = {f"{n.name}.{key}": str(few) for n in graph.nodes.values() for key, few in FEW.get(n.type.name, {}).items()}
    graph = load_graph(path, less)
    unfit = LONGER | ({"render_cycles"} if find_spec("bpy") is None else set())
    lost: set[str] = set()
    for node in graph.nodes.values():  # after those it depends on
        if node.type.name in unfit or any(edge.node in lost for edge in node.edges.values()):
            lost.add(node.name)
    return graph.upto(graph.nodes.keys() - lost)


def moved(graph: Graph, folder: Path) -> Graph:
    """A graph that publishes into a folder of its own."""
    nodes = {
        n.name: replace(n, publish=n.publish and folder / n.publish.relative_to(OUT)) for n in graph.nodes.values()
    }
    return replace(graph, project=folder, nodes=nodes)


def depths(strands: Strands, surface: Field) -> np.ndarray:
    """How deep every strand but its root is inside the body [m], (S,); negative where all of it is outside."""
    points = strands.points.astype(float)
    shots = zip(strands.offsets, strands.offsets[1:], strict=False)
    return np.array([-min(distance(surface, *point) for point in points[begin + 1 : end]) for begin, end in shots])


@pytest.mark.kernels
def test_they_run_and_no_hair_is_in_the_body(section, store, spare, tmp_path):
    short = merged([moved(graph, tmp_path) for graph in section])
    frames = short.all_frames
    outcome = run(short, store, frames, Options(jobs=1, keep_going=True, spare=spare))
    assert not outcome.failures and outcome.exit_code == 0
    for node in short.nodes.values():
        path = node.publish_path(frames[-1])
        assert path is None or path.stat().st_size > 0
        if node.type.name == "simulate_hair":
            strands = read_result(short, store, Task(node.name, frames[-1]), "strands")
            assert np.isfinite(strands.points).all() and np.abs(strands.velocities).max() < 50
            for edge in (edge for plug, edge in node.edges.items() if plug.partition(".")[0] == "surface"):
                first, last = (
                    depths(
                        read_result(short, store, Task(node.name, frame), "strands"),
                        field_of(read_result(short, store, Task(edge.node, frame))),
                    )
                    for frame in (frames[0], frames[-1])
                )
                assert last[first <= 0.0].max(initial=0.0) < DEEPEST
