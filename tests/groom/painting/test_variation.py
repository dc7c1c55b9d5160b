"""Settings that vary over a groom: what is refused, with the place and a value that would be right."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import hairpipe
from hairpipe.errors import BadInput
from hairpipe.formats.pictures import read_image
from hairpipe.groom.strands import unbound
from hairpipe.laws.settings import Drag, Force, Thickness
from hairpipe.values.painting import values_of

GRAPH = """schema = 1
frames = [1, 2]
[tuft]
type = "make_strands"
[hair]
type = "simulate_hair"
in.groom = "tuft"
"""


@pytest.fixture
def groom():
    """Two strands with texture coordinates and a map with a value that is not a number."""
    line = np.linspace(0.0, 0.1, 5)[:, None] * [1.0, 0.0, 0.0]
    bare = unbound(np.array([line, line]), np.tile(np.eye(3, 4), (2, 1, 1)))
    return replace(bare, maps={"torn": np.array([1.0, np.nan])}, root_uv=np.full((2, 2), 0.5, np.float32))


@pytest.mark.parametrize(
    ("setting", "name", "message"),
    [
        (Drag(8.0, map="torn"), "air.drag", r"air.drag is nan 1/s: strands 1 .*0 to 1000 1/s"),
        (Drag(8.0, map="torn", image=Path("a.png")), "air.drag", r"both a map and an image.*one of the two"),
        (Force(2e-5, image=Path("missing.png")), "stiction.force", r"missing.png"),
        (Force(1.0, groups=(("tail", 2.0),)), "stiction.force", r"no group 'tail'"),
        (Thickness(5e-4, low=1e-7, profile=((0.0, 1.0), (1.0, 0.0))), "collisions.thickness", r"is 0 m: strands 0, 1"),
        (Thickness(5e-4, map="thick"), "collisions.thickness", r"no map or group 'thick'.*'torn'"),
    ],
)
def test_bad_variation_is_refused(groom, setting, name, message):
    with pytest.raises(BadInput, match=message):
        values_of(setting, groom, name, read_image)


def test_an_image_needs_texture_coordinates_of_roots(groom):
    bare = replace(groom, root_uv=np.zeros((2, 2), np.float32))
    with pytest.raises(BadInput, match=r"no texture coordinates for an image.*a map"):
        values_of(Drag(8.0, image=Path("a.png")), bare, "air.drag", read_image)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("air.drag = { image = 'none.png' }", r"none.png"),
        ("air.drag = { value = nan }", r"air.drag.value = NaN is not a finite number"),
        ("stiction.force = { value = 2.0 }", r"stiction.force.value = 2.0 is not allowed.*<= 1"),
        ("collisions.thickness = 0.0", r"collisions.thickness.value = 0.0 is not allowed.*1e-06"),
        ("collisions.thickness = { factor = 2.0 }", r"unknown setting 'collisions.thickness.factor'"),
    ],
)
def test_a_graph_with_a_bad_variation_is_refused_before_it_runs(tmp_path, line, message):
    path = tmp_path / "shot.toml"
    path.write_text(GRAPH + line)
    with pytest.raises(BadInput, match=message):
        hairpipe.load(path, cache=tmp_path / "cache").plan()
