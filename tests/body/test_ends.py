"""Scripted motion of ends, meshes and level sets: at its keys when it should be, with the rates of its places."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, Wave, course_of, drive, instant_of, moved, moved_surface
from hairpipe.engine.file.load import load_graph
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.node.settings import check_settings
from hairpipe.engine.plan.planner import plan
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.geometry.collider import SdfSample
from hairpipe.groom.strands import lay_strands
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.values import Ends, Mesh

GROOM = lay_strands(2, 0.3, 10, (1.0, 0.2, 0.0), (0.0, 0.0, 0.01), None, 0.0)
ROOT, TIP = GROOM.points[0], GROOM.points[10]
MOVE = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.2), (0.1, -0.3, 0.2))
TURNED = Track((0.5, 1.0, 2.0), MOVE, (0.0, 90.0, -30.0), (1.0, 2.0, 0.5), (0.05, 0.1, -0.02))
SHAKE = Wave("sine", 2.0, 0.0, (1.0, 0.0, 0.0), 600.0, (0.0, 1.0, 0.0), (-0.1, 0.0, 0.0))
SQUARE = Wave("square", 4.0, 2.0, (0.0, 0.0, 3.0), 360.0, (1.0, 0.0, 0.0))


def ends(time, roots=None, wave=None, tips=None, release=None) -> Ends:
    return drive(GROOM, time, roots or Track(), wave, tips, release)


def placed(place: np.ndarray, point: np.ndarray, strand: int = 0) -> np.ndarray:
    return place[strand, :, :3] @ point + place[strand, :, 3]


@pytest.mark.parametrize("ease", ["smooth", "linear"])
@pytest.mark.parametrize("wave", [None, SHAKE, SQUARE])
def test_rates_are_the_derivatives(ease, wave):
    track, step = replace(TURNED, ease=ease), 1e-6
    for time in (0.2, 0.61, 0.99, 1.3, 1.77, 2.4):
        found = ends(time, track, wave, track)
        before, after = (ends(time + shift, track, wave, track) for shift in (-step, step))
        for name in ("roots", "tips"):
            difference = (getattr(after, name) - getattr(before, name)) / (2 * step)
            np.testing.assert_allclose(getattr(found, name + "_rate"), difference, atol=2e-7)


@pytest.mark.parametrize("ease", ["smooth", "linear"])
def test_keys_are_hit_and_held(ease):
    track = Track((0.5, 1.0, 2.0), MOVE, ease=ease)
    for time, move in ((0.0, MOVE[0]), (0.5, MOVE[0]), (1.0, MOVE[1]), (2.0, MOVE[2]), (9.0, MOVE[2])):
        found = ends(time, track, tips=track)
        np.testing.assert_allclose(placed(found.roots, ROOT), ROOT + move, atol=1e-15)
        np.testing.assert_allclose(placed(found.tips, TIP), TIP + move, atol=1e-15)
    assert not ends(0.4, track).roots_rate.any() and not ends(2.1, track).roots_rate.any()


def test_linear_is_of_constant_speed_and_halves_it_where_it_begins():
    track = Track((0.0, 1.0), ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0)), ease="linear")
    speeds = [ends(time, track).roots_rate[0, 0, 3] for time in (-0.1, 0.0, 0.3, 0.9, 1.0, 1.1)]
    np.testing.assert_allclose(speeds, [0.0, 0.2, 0.4, 0.4, 0.2, 0.0])
    np.testing.assert_allclose(placed(ends(0.3, track).roots, ROOT), ROOT + np.array([0.12, 0.0, 0.0]))


def test_a_turn_is_right_handed_about_an_axis_through_its_pivot():
    track = Track((0.0,), turn=(90.0,), axis=(0.0, 0.0, 2.0), pivot=(0.0, 0.1, 0.0))
    found = ends(0.0, track).roots
    for strand, root in enumerate(GROOM.points[GROOM.offsets[:-1]]):
        np.testing.assert_allclose(placed(found, root, strand), root + np.array([0.1, 0.1, 0.0]), atol=1e-15)
        np.testing.assert_allclose(
            placed(found, root + np.array([0.0, 0.1, 0.0]), strand), root + np.array([0.0, 0.1, 0.0]), atol=1e-15
        )


def test_every_motion_is_rigid():
    for time in (0.3, 0.8, 1.1):
        turn = ends(time, TURNED, SHAKE).roots[:, :, :3]
        np.testing.assert_allclose(turn @ turn.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (2, 3, 3)), atol=1e-14)


def test_a_shake_is_as_fast_as_it_says():
    found = ends(0.125, wave=SHAKE)
    rate = found.roots_rate[0, :, :3] @ found.roots[0, :, :3].T
    np.testing.assert_allclose(rate[0, 2], np.radians(600.0), rtol=1e-12)
    arm = placed(found.roots, ROOT) - (ROOT + np.array([-0.1, 0.0, 0.0]))
    np.testing.assert_allclose(np.linalg.norm(arm), 0.1)
    assert not ends(0.0, wave=SHAKE).roots_rate.any() and not ends(-0.1, wave=SHAKE).roots_rate.any()


def test_a_wave_turns_about_the_end_wherever_the_keys_have_it():
    for time in (0.25, 0.6, 1.4):
        led, shaken = ends(time, TURNED), ends(time, TURNED, replace(SHAKE, pivot=(0.0, 0.0, 0.0)))
        assert np.abs(led.roots - shaken.roots).max() > 0.01
        np.testing.assert_allclose(placed(shaken.roots, ROOT), placed(led.roots, ROOT), atol=1e-12)
        np.testing.assert_allclose(placed(shaken.roots_rate, ROOT), placed(led.roots_rate, ROOT), atol=1e-12)


def test_a_square_wave_turns_round_at_once():
    rates = {time: ends(time, wave=SQUARE).roots_rate[0] for time in (0.01, 0.12, 0.13, 0.24, 0.26)}
    for time, sign in ((0.01, 1), (0.12, 1), (0.13, -1), (0.24, -1), (0.26, 1)):
        centre = rates[time][:, :3] @ ROOT + rates[time][:, 3]
        np.testing.assert_allclose(centre, [0.0, 0.0, 2.0 * sign], atol=1e-12)
    np.testing.assert_allclose(
        placed(ends(0.125, wave=SQUARE).roots, ROOT), ROOT + np.array([0.0, 0.0, 0.25]), atol=1e-12
    )
    for time in (0.0, 0.125, 0.25, 3 / 24, 30 / 24):
        assert not ends(time, wave=SQUARE).roots_rate.any()


def test_tips_are_held_until_they_are_released():
    assert np.isnan(ends(0.0).tips).all() and np.isnan(ends(0.0).tips_rate).all()
    for time, is_free in ((0.0, False), (48 / 24, False), (49 / 24, True)):
        assert np.isnan(ends(time, tips=Track(), release=2.0).tips).all() == is_free
    np.testing.assert_array_equal(ends(5.0, tips=Track()).tips[1], np.eye(3, 4))


def test_keys_that_do_not_belong_together_are_refused():
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"times": (1.0, 1.0)}, "ascending"),
        ({"times": (1.0, 0.5)}, "ascending"),
        ({"times": (0.0, 1.0), "move": MOVE}, "move has 3 keys, times has 2"),
        ({"turn": (30.0,)}, "turn has 1 keys, times has 0"),
        ({"axis": (0.0, 0.0, 0.0)}, "axis = .* has no length"),
    ]
    for keys, reported in wrong:
        with pytest.raises(BadInput, match=reported):
            Track(**keys)
    for name in ("along", "axis"):
        with pytest.raises(BadInput, match=f"{name} = .* has no length"):
            replace(Wave(), **{name: (0.0, 0.0, 0.0)})


@pytest.mark.parametrize("group", ["roots", "wave", "tips"])
def test_the_group_of_an_axis_without_length_is_named(group):
    with pytest.raises(BadInput, match=rf"here: {group}: axis = \[0.0, 0.0, 0.0\] has no length"):
        check_settings(Registry().find("drive_ends"), {group: {"axis": [0.0, 0.0, 0.0]}}, lambda names: "here")


@pytest.mark.parametrize(("frame", "speed"), [(11, 1.0), (12, 13.0), (13, 13.0), (14, 1.0)])
def test_at_a_cut_a_track_has_the_speed_of_one_side(frame, speed):
    """It goes at 1 m/s, but for a metre between the frames 12 and 13."""
    times = (0.0, 11 / 24, 12 / 24, 1.0)
    track = Track(times, tuple((time + (time > 0.47), 0.0, 0.0) for time in times), ease="linear")
    plain, cut = (course_of(track, instant_of(frame, 1, 24.0, cuts)) for cuts in ((), (13,)))
    assert (plain.shift_rate[0], cut.shift_rate[0]) == pytest.approx((speed, 1.0))
    assert cut.shift == pytest.approx(plain.shift, abs=1e-8)


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
