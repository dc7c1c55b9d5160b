"""A body carried along keys moves as they say; its level set is baked once, whatever the motion."""

from pathlib import Path

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, moved, moved_surface
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan.planner import plan
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.geometry.collider import SdfSample
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.values import Mesh

VOXEL, HALF_WIDTH, FRAME = 0.05, 6.0, 1.0 / 24.0
TURNING = Track((0.0, 1.0), ((0.0, 0.0, 0.0), (0.6, -0.4, 0.2)), (0.0, 300.0), (1.0, 2.0, 0.5), (0.2, 0.0, 0.1))
GRAPH = """schema = 1
frames = [1, 3]
fps = 24
[block]
type = "make_box"
[surface]
type = "bake_levelset"
in.body = "block"
voxel = 0.02
[parts]
type = "move_levelset"
in.surface = "surface"
motion = { times = [0.0, 1.0], move = [[0.0, 0.0, 0.0], [0.0, 0.1, 0.0]], turn = [0.0, 30.0] }
"""


def test_a_mesh_is_where_the_keys_say_and_its_velocities_are_the_derivative(box):
    mesh = box()
    track = Track(
        (0.0, 1.0), ((0.0, 0.0, 0.0), (0.3, -0.1, 0.2)), (0.0, 200.0), (1.0, 2.0, 0.5), (0.2, 0.0, 0.1), "smooth"
    )
    for time in (-0.3, 0.2, 0.7, 1.5):
        now, (before, after) = moved(mesh, track, time), (moved(mesh, track, time + t) for t in (-1e-6, 1e-6))
        assert now.velocities is not None
        np.testing.assert_allclose(now.velocities, (after.points - before.points) / 2e-6, atol=1e-8)
    np.testing.assert_array_equal(moved(mesh, track, -0.3).points, mesh.points)


def test_a_turn_is_about_a_place_in_space(box):
    turned = moved(box(), Track((0.0,), turn=(90.0,), axis=(0.0, 0.0, 1.0), pivot=(1.0, 0.0, 0.0)), 0.0)
    x, y, z = box().points.T
    np.testing.assert_allclose(turned.points, np.stack([1.0 - y, x - 1.0, z], axis=1), atol=1e-14)


def test_a_mesh_that_moves_by_itself_continues_doing_so(box):
    track = Track((0.0, 1.0), ((0.0, 0.0, 0.0), (0.3, -0.1, 0.2)), (0.0, 200.0), (1.0, 2.0, 0.5), (0.2, 0.0, 0.1))
    still, speed = box(), np.array([2.0, -0.5, 0.3])

    def at(time):
        moving = Mesh(still.points + time * speed, still.triangles, np.tile(speed, (len(still.points), 1)))
        return moved(moving, track, time)

    now, before, after = (at(0.4 + t) for t in (0.0, -1e-6, 1e-6))
    np.testing.assert_allclose(now.velocities, (after.points - before.points) / 2e-6, atol=1e-8)


@pytest.mark.parametrize("begin", [0.2, 0.7])
def test_between_frames_a_level_set_is_that_of_the_body_where_it_is_then(box, begin):
    surface = bake(box(), VOXEL, HALF_WIDTH)
    moving = build_collider_parts(*(moved_surface(surface, TURNING, begin + t) for t in (0.0, FRAME)), FRAME)
    now = moved(box(), TURNING, begin + 0.4 * FRAME)
    corners = now.points[now.triangles]
    shares = np.random.default_rng(0).dirichlet(np.full(3, 4.0), (200, len(corners)))
    points = np.einsum("stc,tcx->stx", shares, corners).reshape(-1, 3)
    probe = SdfSample.blank(len(points))
    moving.probe(points, 0.4 * FRAME, probe)
    assert np.abs(probe.distance).max() < 1e-4
    assert now.velocities is not None
    exact = np.einsum("stc,tcx->stx", shares, now.velocities[now.triangles]).reshape(-1, 3)
    assert np.abs(probe.velocity - exact).max() < 1e-3 * np.abs(exact).max()


def test_a_level_set_of_a_body_that_moves_by_itself_is_refused(box):
    mesh = box()
    falling = Mesh(mesh.points, mesh.triangles, np.tile([0.0, -1.0, 0.0], (len(mesh.points), 1)))
    with pytest.raises(BadInput, match=r"in\.surface: the body is not at rest .*mesh at rest"):
        moved_surface(bake(falling, VOXEL, HALF_WIDTH), TURNING, 0.0)


def test_a_level_set_is_baked_once_for_all_frames_and_motions(tmp_path):
    file, store = Path(tmp_path, "shot.toml"), Store(tmp_path / "cache")
    file.write_text(GRAPH, encoding="utf-8")
    graph = load_graph(file)
    assert run(graph, store, None, Options(jobs=1)).exit_code == 0
    baked = {entry.key for entry in plan(graph, store) if entry.task.node == "surface"}
    file.write_text(GRAPH.replace("30.0", "45.0"), encoding="utf-8")
    status = {(entry.task.node, entry.status) for entry in plan(load_graph(file), store)}
    assert len(baked) == 1
    assert status == {("block", "cached"), ("surface", "cached"), ("parts", "run")}
