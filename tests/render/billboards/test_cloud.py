"""Laws of a whole picture of particles."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import KDTree

from hairpipe.engine import Workspace
from hairpipe.errors import BadInput
from hairpipe.groom.strands import unbound
from hairpipe.nodes.preview_particles import preview_particles
from hairpipe.nodes.preview_particles import style as style_node
from hairpipe.render.camera import Shot
from hairpipe.render.cloud import CloudStyle, draw_cloud, style_cloud
from hairpipe.render.kajiya_kay import lie
from hairpipe.values import Cloud, Mesh, Particles, Strands

BROWN = np.array([0.12, 0.06, 0.03])


@pytest.fixture(scope="module")
def particles(hair: Strands, head: Mesh) -> Particles:
    """A particle on every third point of arcs around a head, those at the roots being below the skin."""
    points = hair.points.astype(float)
    _, nearest = KDTree(head.points[head.triangles].mean(axis=1)).query(points[hair.offsets[:-1]])
    groom = unbound(points.reshape(300, 16, 3), np.tile(np.eye(3, 4), (300, 1, 1)))
    groom = replace(groom, root_triangles=nearest.astype(np.int32), root_barycentrics=np.full((300, 3), 1 / 3))
    some, arcs = np.arange(0, len(points), 3), np.tile(np.arange(16) / 15 * 0.2 - 0.001, 300)
    some = some[np.argsort(arcs[some] >= 0.0, kind="stable")]
    rest = lie(points, hair.offsets, (some // 16).astype(np.int32), 2 * some)
    strands = (some // 16).astype(np.int32)
    links = np.zeros((0, 2), np.int32)
    return Particles(groom, strands, arcs[some], *rest, np.full(len(some), 5e-5), links, np.zeros(0), 0.02, 0.015)


@pytest.fixture(scope="module")
def cloud(particles: Particles) -> Cloud:
    return Cloud(particles.points, np.zeros(particles.points.shape, np.float32), particles.directions)


@pytest.fixture(scope="module")
def style(particles: Particles) -> CloudStyle:
    return style_cloud(particles, BROWN, 1.0)


def test_scene_and_camera_turned_together_give_the_same_picture(cloud, style, head) -> None:
    turn = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]])
    eye, target = np.array([0.5, 1.7, 1.1]), np.array([0.0, 1.55, 0.0])
    still = draw_cloud(cloud, style, head, Shot(160, 160, eye=tuple(eye), target=tuple(target)))
    turned = replace(cloud, points=cloud.points @ turn.T, directions=cloud.directions @ turn.T)
    shot = Shot(160, 160, eye=tuple(turn @ eye), target=tuple(turn @ target))
    off = np.abs(still.astype(int) - draw_cloud(turned, style, Mesh(head.points @ turn.T, head.triangles), shot))
    assert off.mean() < 0.5 and np.mean(off > 8) < 0.01


def test_the_camera_follows_a_head_that_walks(cloud, style, head) -> None:
    step = np.array([2.0, 0.0, -1.0])
    there = replace(cloud, points=cloud.points + step), style, Mesh(head.points + step, head.triangles)
    off = np.abs(draw_cloud(cloud, style, head, Shot(160, 160)).astype(int) - draw_cloud(*there, Shot(160, 160)))
    assert off.mean() < 0.1


def test_pictures_do_not_depend_on_parallel_work(cloud, style, head) -> None:
    shots = [Shot(120, 90, view) for view in ("front", "back", "side", "three_quarter")]
    alone = [draw_cloud(cloud, style, head, shot) for shot in shots]
    with ThreadPoolExecutor(4) as pool:
        beside = list(pool.map(lambda shot: draw_cloud(cloud, style, head, shot), shots))
    assert all(np.array_equal(a, b) for a, b in zip(alone, beside, strict=True))


def test_a_fast_picture_is_like_one_that_takes_its_time(cloud, style, head) -> None:
    fast, slow = (draw_cloud(cloud, style, head, Shot(100, 80, grain=grain)) for grain in (1, 2))
    assert fast.shape == slow.shape == (80, 100, 3)
    assert np.abs(fast.astype(int) - slow).mean() < 6.0


def test_hair_casts_a_shadow_on_the_body(particles, cloud, head) -> None:
    """A dense curtain between the lamps and a plate, out of the camera's sight, leaves the plate dark."""
    floor = Mesh(head.points * (1.0, 0.0, 1.0) + (0.0, 1.2, 0.0), head.triangles)
    high = replace(cloud, points=cloud.points * (1.0, 0.2, 1.0) + (0.0, 1.25, 0.0))
    away = replace(cloud, points=cloud.points + np.array((0.0, 40.0, 0.0)))
    shot = Shot(60, 60, eye=(0.2, 1.3, 0.0), target=(0.0, 1.2, 0.0))
    fixed = style_cloud(replace(particles, arcs=np.abs(particles.arcs)), BROWN, 1.0)  # the frame does not follow it
    fixed = fixed._replace(framing=replace(fixed.framing, target=np.array([0.0, 1.4, 0.0])))
    shaded, lit = (draw_cloud(some, fixed, floor, shot) for some in (high, away))
    assert shaded[30:, 20:40].mean() < 0.8 * lit[30:, 20:40].mean()


def test_undrawable_inputs_are_named(cloud, style, head) -> None:
    lost = replace(cloud, points=cloud.points.copy())
    lost.points[7] = np.nan
    with pytest.raises(BadInput, match="particle 7 is not finite"):
        draw_cloud(lost, style, head, Shot(60, 60))
    fewer = Cloud(cloud.points[1:], cloud.velocities[1:], cloud.directions[1:])
    with pytest.raises(BadInput, match="a cloud of 1599 particles, at rest there are 1600"):
        draw_cloud(fewer, style, head, Shot(60, 60))
    with pytest.raises(BadInput, match="a body that has 3"):
        draw_cloud(cloud, style, Mesh(head.points, head.triangles[:3]), Shot(60, 60))


def test_every_setting_of_the_node_shows(cloud, particles, head, tmp_path: Path) -> None:
    def shoot(colour=(0.37, 0.25, 0.17), size=1.0, **settings: object) -> np.ndarray:
        prepared = style_node(particles, colour, size)
        given = {"width": 96, "height": 64, **settings}
        with Image.open(
            preview_particles(cloud, particles, head, Workspace(tmp_path), prepared, **given).path
        ) as image:
            return np.asarray(image)

    plain = shoot()
    assert plain.shape == (64, 96, 3)
    for changed in (
        {"view": "back"},
        {"eye": (1.0, 1.6, 0.5)},
        {"target": (0.05, 1.6, 0.0)},
        {"fov": 12.0},
        {"colour": (0.8, 0.7, 0.4)},
        {"size": 2.0},
    ):
        assert not np.array_equal(plain, shoot(**changed)), changed
