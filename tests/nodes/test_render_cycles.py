"""The node hands on what its settings say; `tests/render/cycles` looks at the pictures."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hairpipe.engine import Time, Workspace
from hairpipe.nodes.render_cycles import render_cycles
from hairpipe.render import cycles as scene
from hairpipe.render.camera import Shot
from hairpipe.render.dual_scattering import pigment_colour
from hairpipe.render.film import develop, linear
from hairpipe.values import Strands

HAIR = Strands(np.zeros((2, 3), np.float32), np.zeros((2, 3), np.float32), np.array([0, 2], np.int32), 80e-6)
LIGHT = np.full((16, 24, 3), 0.2, np.float32)


@pytest.fixture
def shoot(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
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


def test_colour_is_that_of_the_pigment_or_the_one_given(shoot):
    assert np.array_equal(shoot(melanin=0.3, redness=0.9)[3].colour, pigment_colour(0.3, 0.9))
    assert np.array_equal(shoot(melanin=0.3, colour=(0.2, 0.5, 0.9))[3].colour, linear((0.2, 0.5, 0.9)))


def test_shutter_is_a_part_of_the_frame(shoot):
    assert shoot(shutter=0.5)[4].shutter == pytest.approx(0.02)


def test_camera_is_that_of_the_preview(shoot):
    place, target = (1.0, 1.5, 0.5), (0.0, 1.6, 0.0)
    shot = shoot(width=24, height=16, view="back", eye=place, target=target, fov=30.0)[2]
    assert shot == Shot(24, 16, "back", 30.0, place, target)
