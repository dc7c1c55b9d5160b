"""The node takes the picture that its settings ask for."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hairpipe.engine import Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.nodes.preview import preview
from hairpipe.values import Normals, Strands

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


def test_writes_a_picture_of_the_size(hair: Strands, tmp_path: Path) -> None:
    assert shoot(hair, tmp_path, width=96, height=64).shape == (64, 96, 3)


def test_every_setting_shows(hair: Strands, tmp_path: Path) -> None:
    hair.velocities[:, 0] = 2.0
    plain = shoot(hair, tmp_path, width=96, height=96)
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
        assert not np.array_equal(plain, shoot(hair, tmp_path, width=96, height=96, **changed)), changed


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


def test_blond_hair_is_brighter_than_black(hair: Strands, tmp_path: Path) -> None:
    blond = shoot(hair, tmp_path, width=96, height=96, colour=(0.85, 0.7, 0.45)).mean()
    assert blond > shoot(hair, tmp_path, width=96, height=96, colour=(0.05, 0.05, 0.05)).mean() + 2


def test_lost_strands_are_named(hair: Strands, tmp_path: Path) -> None:
    hair.points[9 * 7 + 2] = np.nan
    with pytest.raises(BadInput, match="not finite: 7"):
        shoot(hair, tmp_path)
