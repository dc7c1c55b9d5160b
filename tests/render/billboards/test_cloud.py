"""Pictures of particles: billboards, their streaks and light, and laws of a whole picture."""

from collections.abc import Callable
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
from hairpipe.render.cloud import (
    DARK,
    FADE,
    KINDS,
    SUNK,
    CloudStyle,
    Levels,
    Sprites,
    draw_cloud,
    lay_sprites,
    paint,
    streak_levels,
    style_cloud,
    transmittances,
)
from hairpipe.render.kajiya_kay import lie
from hairpipe.values import Cloud, Mesh, Particles, Strands


@pytest.fixture(scope="session")
def plain() -> Levels:
    """A texture that covers everything, at as many levels as streaks have: the same kernels."""
    return (np.ones((1, 8, 4, 2), np.float32),) * 6


@pytest.fixture(scope="session")
def boards() -> Callable[..., Sprites]:
    """Lay billboards of 20 pixels by 10 that face the eye, or lean away from it by an angle [deg], at depths [m]."""

    def lay(depths: list[float], opacity: float, lean: float = 0.0, turn: float = 0.5) -> Sprites:
        count = len(depths)
        places = np.column_stack([np.tile((32.3, 32.4), (count, 1)), depths])
        ahead, aside = np.sin(np.radians(lean)), 100.0 * np.cos(np.radians(lean))
        along = np.tile((aside * np.cos(turn), aside * np.sin(turn), ahead), (count, 1))
        return lay_sprites(places, along, np.full(count, 100.0), 0.1, opacity, np.zeros(count, int))

    return lay


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


OPEN, NOBODY = np.full((64, 64), np.inf), np.zeros((0, 3))


def test_each_billboard_takes_its_share_of_the_light_that_is_left(boards, plain) -> None:
    points = np.array([[32.3, 32.4, depth] for depth in (0.5, 3.5, 9.0)] + [[3.0, 3.0, 9.0], [-5.0, 3.0, 9.0]])
    light = transmittances(boards([3.0, 1.0, 2.0, 4.0], 0.3), plain, points, OPEN)
    assert light[:4] == pytest.approx(0.7 ** np.array([2, 0, 1, 3]))
    assert light[4:] == pytest.approx([1.0, 0.7**3, 0.7**4, 1.0, 1.0])


def test_there_is_no_light_behind_what_is_opaque(boards, plain) -> None:
    behind = np.array([[32.3, 32.4, 2.0]])
    assert transmittances(boards([1.0, 3.0], 1.0), plain, behind, OPEN).tolist() == [1.0, DARK, DARK]
    body = np.full((64, 64), 10.0)
    light = transmittances(boards([1.0, 20.0], 0.3), plain, np.array([[20.0, 20.0, 9.0], [20.0, 20.0, 20.0]]), body)
    assert light.tolist() == [1.0, DARK, 1.0, DARK]


def test_a_billboard_half_behind_the_body_takes_half_of_the_light(boards, plain) -> None:
    body = np.where(np.arange(64)[:, None] < 32, 10.0, np.inf) * np.ones(64)
    assert transmittances(boards([20.0], 0.3), plain, NOBODY, body) == pytest.approx([0.5], abs=0.05)


def test_the_order_in_which_they_come_does_not_matter(boards, plain) -> None:
    rng = np.random.default_rng(4)
    sprites = boards(list(rng.random(50)), 0.3)
    sprites = sprites._replace(places=sprites.places + np.c_[rng.uniform(-20, 20, (50, 2)), np.zeros(50)])
    points, order = rng.uniform(0.0, 1.0, (40, 3)) * (64.0, 64.0, 1.0), rng.permutation(50)
    light = transmittances(sprites, plain, points, OPEN)
    assert light.min() < 0.3
    other = transmittances(Sprites(*(field[order] for field in sprites)), plain, points[::-1], OPEN)
    assert np.array_equal(other[:50], light[order]) and np.array_equal(other[50:], light[50:][::-1])


FAR = np.full((64, 64), np.inf)


def painted(sprites: Sprites, levels, colours: np.ndarray | None = None, depth: np.ndarray = FAR) -> np.ndarray:
    """Paint white, or these colours, over black."""
    film = np.zeros((64, 64, 3), np.float32)
    paint(film, depth, sprites, np.ones((len(sprites.places), 3)) if colours is None else colours, levels)
    return film


@pytest.mark.parametrize("turn", [0.0, 0.5, np.pi / 2, 2.2])
def test_a_billboard_that_faces_the_eye_covers_its_area_times_its_opacity(turn, boards, plain) -> None:
    film = painted(boards([1.0], 0.4, turn=turn), plain)
    assert film.sum() / 3 == pytest.approx(0.4 * 20 * 10, rel=0.03)
    assert np.unique(film) == pytest.approx([0.0, 0.4])


@pytest.mark.parametrize("lean", [30.0, 60.0, 75.0])
def test_hair_that_leans_away_is_shorter_and_denser(lean, boards, plain) -> None:
    """As much hair is seen by fewer rays; nearer to the ray than asin 0.15 that ends."""
    facing, leaning = (painted(boards([1.0], 0.2, angle), plain) for angle in (0.0, lean))
    assert leaning.sum() == pytest.approx(facing.sum(), rel=0.06)
    assert leaning.max() == pytest.approx(0.2 / np.cos(np.radians(lean)), rel=1e-5)
    assert painted(boards([1.0], 0.01, 89.0), plain).max() == pytest.approx(0.01 / 0.15, rel=1e-5)


def test_the_nearer_lies_over_the_farther_in_whatever_order_they_come(boards, plain) -> None:
    sprites, colours = boards([3.0, 1.0, 2.0], 0.4), np.eye(3)
    film = painted(sprites, plain, colours)
    assert film[32, 32] == pytest.approx([0.4 * 0.6**2, 0.4, 0.4 * 0.6])
    for order in ([1, 2, 0], [2, 1, 0]):
        other = Sprites(*(field[order] for field in sprites))
        assert np.array_equal(painted(other, plain, colours[order]), film)


def test_a_body_hides_what_is_behind_it_softly(boards, plain) -> None:
    sprites = boards([1.0], 0.4)
    for ahead, share in ((0.1, 1.0), (FADE - SUNK, 1.0), (0.5 * FADE - SUNK, 0.5), (-SUNK - 1e-6, 0.0)):
        film = painted(sprites, plain, depth=np.full((64, 64), 1.0 + ahead))
        assert film[32, 32] == pytest.approx(0.4 * share, abs=1e-5)


def test_nothing_is_drawn_behind_the_eye_or_outside_of_the_film(boards, plain) -> None:
    assert painted(boards([-1.0, 0.0], 0.4), plain).max() == 0.0
    sprites = boards([1.0], 0.4)
    assert painted(sprites._replace(places=sprites.places + np.array((1e6, -1e6, 0.0))), plain).max() == 0.0


def test_coarser_levels_cover_as_much_and_are_as_bright() -> None:
    covers = np.array([level[..., 0].mean(axis=(1, 2)) for level in streak_levels()])
    light = np.array([level.prod(axis=3).mean(axis=(1, 2)) for level in streak_levels()])
    assert np.ptp(covers, axis=0).max() < 1e-5 and np.ptp(light, axis=0).max() < 1e-5
    assert covers.min() > 0.1 and covers.max() < 0.6


def test_streaks_run_along_the_hair_and_fade_at_ends_and_sides() -> None:
    cover = streak_levels()[0][..., 0]
    assert cover.min() >= 0.0 and cover.max() <= 1.0
    assert np.abs(np.diff(cover, axis=1)).mean() < 0.25 * np.abs(np.diff(cover, axis=2)).mean()
    rim = (cover[:, 0], cover[:, -1], cover[:, :, 0], cover[:, :, -1])
    assert max(edge.mean() for edge in rim) < 0.05 * cover.mean()


def test_kinds_differ() -> None:
    cover = streak_levels()[0][..., 0].reshape(KINDS, -1)
    assert np.abs(np.corrcoef(cover) - np.eye(KINDS)).max() < 0.9
