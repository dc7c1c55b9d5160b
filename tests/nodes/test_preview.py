"""Nodes of pictures take those that their settings ask for."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hairpipe.engine import File, Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import write_png
from hairpipe.nodes.flipbook import flipbook
from hairpipe.nodes.make_bust import make_bust
from hairpipe.nodes.preview import preview
from hairpipe.nodes.preview_scalp import preview_scalp
from hairpipe.nodes.render_cycles import render_cycles
from hairpipe.render import cycles as scene
from hairpipe.render.camera import Shot
from hairpipe.render.dual_scattering import pigment_colour
from hairpipe.render.film import develop, linear
from hairpipe.values import Body, Normals, Strands

TIME = Time(30, 24.0)


@pytest.fixture
def hair() -> Strands:
    """Forty strands that zigzag down from a disc."""
    rng = np.random.default_rng(2)
    roots = np.c_[rng.uniform(-0.1, 0.1, 40), np.full(40, 1.7), rng.uniform(-0.1, 0.1, 40)]
    points = roots[:, None] + np.linspace(0, 0.2, 9)[None, :, None] * [0, -1, 0]
    points[:, ::2, 0] += 0.004
    points = points.reshape(-1, 3).astype(np.float32)
    return Strands(points, np.zeros_like(points), np.arange(0, 361, 9, dtype=np.int32), 80e-6)


def shoot(hair: Strands, folder: Path, normals: Normals | None = None, **settings: object) -> np.ndarray:
    """Run the node and read its file."""
    with Image.open(preview(hair, None, normals, Workspace(folder), TIME, **settings).path) as image:
        assert image.format == "PNG"
        return np.asarray(image)


def test_every_setting_shows(hair: Strands, tmp_path: Path) -> None:
    hair.velocities[:, 0] = 2.0
    plain = shoot(hair, tmp_path, width=96, height=64)
    assert plain.shape == (64, 96, 3)
    for changed in (
        {"view": "back"},
        {"eye": (1.0, 1.6, 0.5)},
        {"target": (0.05, 1.6, 0.0)},
        {"fov": 12.0},
        {"colour": (0.8, 0.7, 0.4)},
        {"thickness": 2.0},
        {"curve": "bspline"},
        {"shading": "dual"},
        {"supersampling": 2},
        {"turn": 1.0},
        {"shutter": 0.5},
    ):
        assert not np.array_equal(plain, shoot(hair, tmp_path, width=96, height=64, **changed)), changed


def test_the_eye_has_turned_by_as_much_as_frames_have_passed(hair: Strands, tmp_path: Path) -> None:
    views = ({"view": "front", "turn": 3.0}, {"view": "side"})
    turned, side = (shoot(hair, tmp_path, width=96, height=96, **view).astype(int) for view in views)
    assert np.abs(turned - side).mean() < 0.01


def test_normals_show_by_their_share_and_are_those_of_the_hair(hair: Strands, tmp_path: Path) -> None:
    away = Normals(np.tile(np.float32((0.0, -1.0, 0.0)), (len(hair.points), 1)))
    plain, none, some, all_of_it = (
        shoot(hair, tmp_path, *how, width=96, height=96, **share).mean()
        for how, share in (((), {}), ((away,), {"lambert": 0.0}), ((away,), {}), ((away,), {"lambert": 1.0}))
    )
    assert plain == none and none > some > all_of_it
    with pytest.raises(BadInput, match="359 normals of 360 points"):
        shoot(hair, tmp_path, Normals(away.vectors[1:]))


@pytest.fixture(scope="module")
def bust() -> Body:
    return make_bust()


@pytest.mark.kernels
def test_the_scalp_is_shown_from_three_sides_and_the_face_is_not_painted(bust: Body, tmp_path: Path) -> None:
    with Image.open(preview_scalp(bust, Workspace(tmp_path), width=120, height=160).path) as image:
        picture = np.asarray(image).astype(float)
    assert picture.shape == (160, 3 * 120 + 8, 3)
    red = picture[..., 0] - picture[..., 2] > 60
    front, side, back = (red[:, place : place + 120] for place in (0, 124, 248))
    assert 100 < front.sum() < side.sum() and front.sum() < back.sum(), "there is more of it behind than before"
    rows = np.flatnonzero(front.any(axis=1))
    assert rows.max() < 90 and np.flatnonzero(back.any(axis=1)).max() > rows.max() + 5


def test_missing_map_is_reported(bust: Body, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"map: the body has no map 'beard' \(its maps: 'length', 'scalp'\)"):
        preview_scalp(bust, Workspace(tmp_path), map="beard")


def test_shows_the_frames_in_order_at_the_speed_of_the_shot(tmp_path: Path) -> None:
    numbers = (1001, 1002, 1004, 1010)
    for n in numbers:
        write_png(tmp_path / f"{n}.png", np.full((24, 32, 3), (n - 1000) * 20, np.uint8))
    pictures = Frames(numbers, lambda n: File(tmp_path / f"{n}.png"))
    film = flipbook(pictures, Time(1001, 25.0), Workspace(tmp_path), scale=0.5, quality=90)
    with Image.open(film.path) as image:
        assert image.n_frames == 4 and image.size == (16, 12)
        for place, (n, duration) in enumerate(zip(numbers, (40, 80, 240, 40), strict=True)):
            image.seek(place)
            shown = np.asarray(image.convert("RGB"))
            assert abs(shown.mean() - (n - 1000) * 20) < 4 and image.info["duration"] == duration


HAIR = Strands(np.zeros((2, 3), np.float32), np.zeros((2, 3), np.float32), np.array([0, 2], np.int32), 80e-6)
LIGHT = np.full((16, 24, 3), 0.2, np.float32)


@pytest.fixture
def traced(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """Run the node, and return what the renderer was told."""
    reported = []

    def trace(*arguments: object) -> np.ndarray:
        reported[:] = arguments
        return LIGHT

    def run(**settings: object) -> list:
        with Image.open(render_cycles(HAIR, None, Workspace(tmp_path), Time(3, 25.0), **settings).path) as image:
            assert image.format == "PNG" and np.array_equal(np.asarray(image), develop(LIGHT, 1))
        return reported

    monkeypatch.setattr(scene, "trace_hair", trace)
    return run


def test_colour_is_that_of_the_pigment_or_the_one_given(traced):
    assert np.array_equal(traced(melanin=0.3, redness=0.9)[3].colour, pigment_colour(0.3, 0.9))
    assert np.array_equal(traced(melanin=0.3, colour=(0.2, 0.5, 0.9))[3].colour, linear((0.2, 0.5, 0.9)))


def test_shutter_is_a_part_of_the_frame(traced):
    assert traced(shutter=0.5)[4].shutter == pytest.approx(0.02)


def test_camera_is_that_of_the_preview(traced):
    place, target = (1.0, 1.5, 0.5), (0.0, 1.6, 0.0)
    shot = traced(width=24, height=16, view="back", eye=place, target=target, fov=30.0)[2]
    assert shot == Shot(24, 16, "back", 30.0, place, target)
