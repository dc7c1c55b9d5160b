"""The bake_levelset node."""

import numpy as np
import pytest

from hairpipe import openvdb_library
from hairpipe.engine import code
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan import key
from hairpipe.engine.plan.key import Resolver
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.nodes.bake_levelset import bake_levelset
from hairpipe.values import Mesh
from tests.sources import HOME

TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)


def test_settings_reach_the_level_set():
    surface = bake_levelset(Mesh(TETRAHEDRON, FACES), voxel=0.05, half_width=4.0)
    assert (surface.voxel, surface.half_width) == (0.05, 4.0)
    assert surface.distance.min() < -0.1
    assert np.abs(surface.distance).max() == np.float32(0.2)


def test_openvdb_is_an_engine(openvdb):
    body = Mesh(TETRAHEDRON, FACES)
    ours, theirs = (bake_levelset(body, voxel=0.05, half_width=4.0, engine=name) for name in ("hairpipe", "openvdb"))
    grid = openvdb.FloatGrid.createLevelSetFromPolygons(
        TETRAHEDRON.astype(np.float32),
        triangles=FACES.astype(np.uint32),
        transform=openvdb.createLinearTransform(voxelSize=0.05),
        halfWidth=4.0,
    )
    block, places = np.empty((9, 9, 9), np.float32), np.argwhere(theirs.bricks >= 0)
    for place in places:
        first = 8 * place + np.rint(theirs.origin / 0.05).astype(int)
        grid.copyToArray(block, ijk=tuple(first.tolist()))
        found = theirs.distance[theirs.bricks[tuple(place)]]
        assert np.array_equal(
            np.clip(found, -np.float32(0.2), np.float32(0.2)), np.clip(block, -np.float32(0.2), np.float32(0.2))
        )
    assert (
        len(places) and 0.0 < np.abs(np.maximum(theirs.distance, -0.2) - np.maximum(ours.distance, -0.2)).max() < 0.03
    )
    with pytest.raises(BadInput, match="OpenVDB converts solid bodies alone"):
        bake_levelset(None, body, voxel=0.05, engine="openvdb")


def test_a_missing_openvdb_is_named(monkeypatch):
    monkeypatch.setattr(openvdb_library, "find_openvdb", lambda: None)
    with pytest.raises(
        BadInput,
        match=r"bake_levelset: OpenVDB's Python module is not installed \(Python .*cycles\]' with Python 3.11 or 3.13",
    ):
        bake_levelset(Mesh(TETRAHEDRON, FACES), voxel=0.05, half_width=4.0, engine="openvdb")


def test_holes_are_refused_on_request():
    opened = Mesh(TETRAHEDRON, FACES[1:])
    with pytest.raises(BadInput, match="the surface is open: 1 hole: 3 edges"):
        bake_levelset(opened, voxel=0.05, half_width=4.0, holes="refuse")
    with pytest.warns(UserWarning, match="capped 1 hole"):
        filled = bake_levelset(opened, voxel=0.05, half_width=4.0)
    whole = bake_levelset(Mesh(TETRAHEDRON, FACES), voxel=0.05, half_width=4.0)
    assert np.allclose(filled.distance, whole.distance, atol=1e-6)


def test_versions_of_openvdb_key_its_own_distances_alone(monkeypatch, tmp_path):
    """To install Blender, or another release of it, recomputes nothing of the demo, but what OpenVDB computed."""
    path = HOME / "graphs" / "demo.toml"

    def keys(**versions):
        installed = code.version.__wrapped__
        for module in (code, key):  # which takes it from there
            monkeypatch.setattr(module, "version", lambda name: versions.get(name) or installed(name))
        found = {}
        for engine in ("hairpipe", "openvdb"):
            graph = load_graph(path, {"surface.engine": engine})
            resolver = Resolver(graph, Store(tmp_path), graph.frames[:1])
            found[engine] = {name: (resolver.codes[name].digest, resolver.settings[name]) for name in graph.nodes}
        monkeypatch.undo()
        return found

    without, with_blender = keys(bpy="none", openvdb="none"), keys(bpy="5.0.1", openvdb="none")
    assert without["hairpipe"] == with_blender["hairpipe"]
    changed = {name for name, parts in without["openvdb"].items() if parts != with_blender["openvdb"][name]}
    assert changed == {"surface"}
