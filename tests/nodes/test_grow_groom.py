"""Hair on our own bust, and the settings as a graph file gives them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hairpipe.body.scalp import Scalp
from hairpipe.engine.node.settings import build_settings, check_settings
from hairpipe.errors import BadInput
from hairpipe.geometry.solid import distance_and_normal, solid_of
from hairpipe.groom.growing import closed
from hairpipe.groom.settings import Curl
from hairpipe.nodes.grow_groom import grow_groom
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.make_bust import make_bust
from hairpipe.values import Body, Mesh
from hairpipe.values.painting import Paint, PaintedMetres

NODE = grow_groom.__node__


@pytest.fixture(scope="module")
def bust() -> Body:
    return make_bust()


def given(**settings: object) -> dict[str, object]:
    """Settings of a graph file as the node gets them."""

    def place(names: Sequence[str]) -> str:
        return ".".join(names)

    return build_settings(NODE, check_settings(NODE, settings, place))


def test_a_painted_setting_is_a_number_or_a_table() -> None:
    assert given(length=0.3)["length"] == PaintedMetres(0.3)
    assert given(length={"map": "length", "variation": 0.1})["length"] == PaintedMetres(
        0.25, variation=0.1, map="length"
    )
    assert given()["curl"] is None and given()["density"] is None
    curl = {"radius": 0.01, "pitch": {"value": 0.02, "low": 0.01, "image": "pitch.png"}}
    assert given(curl=curl)["curl"] == Curl(PaintedMetres(0.01), PaintedMetres(0.02, 0.01, image=Path("pitch.png")))
    assert given(density={"image": "d.png"})["density"] == Paint(image=Path("d.png"))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"length": -0.1}, r"length.value = -0.1 is not allowed \(a number in m, > 0\)"),
        ({"lift": {"value": 120.0}}, r"lift.value = 120.0 is not allowed \(a number in deg, >= 0, <= 90\)"),
        ({"length": {"vale": 0.1}}, "unknown setting 'length.vale'"),
        ({"curl": 0.01}, "curl = 0.01 is not allowed"),
        ({"strands": 0}, "strands = 0 is not allowed"),
    ],
)
def test_invalid_settings_are_reported(settings: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        given(**settings)


@pytest.mark.parametrize("style", [{}, {"curl": {}, "segments": 60}], ids=["straight", "curly"])
@pytest.mark.kernels
def test_hair_on_the_bust_lies_on_the_head_and_leaves_the_face_free(bust: Body, style: dict[str, object]) -> None:
    groom = grow_groom(bust, **given(strands=300, **style))
    points = groom.points.reshape(300, -1, 3)
    solid = solid_of(bust.mesh)
    depth = [distance_and_normal(solid, tuple(p), 0)[0] for p in points[:, 1:].reshape(-1, 3)]
    assert min(depth) > 0.0
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1)
    assert np.allclose(lengths, 0.25, rtol=1e-9)
    nose = bust.mesh.points[np.argmax(bust.mesh.points[:, 2] * (bust.mesh.points[:, 1] > 0.25))]
    before_the_face = (np.abs(points[..., 0]) < 0.02) & (points[..., 1] < nose[1] + 0.03) & (points[..., 2] > 0.06)
    assert np.mean(before_the_face.any(axis=1)) < 0.01
    assert (points[:, -1, 1] < points[:, 0, 1]).mean() > 0.99, "it hangs"


def test_an_image_thins_the_hair_out(bust: Body, tmp_path: Path) -> None:
    picture = np.zeros((64, 64), np.uint8)
    picture[:, 26:] = 255  # in the bust's texture hair is at 0.1 < u < 0.6, and on the left half at u > 0.4
    Image.fromarray(picture).save(tmp_path / "half.png")
    groom = grow_groom(bust, **given(strands=200, segments=4, density={"image": str(tmp_path / "half.png")}))
    assert (groom.root_uv[:, 0] > 0.39).all() and groom.points[groom.offsets[:-1], 0].min() > -0.01
    everywhere = grow_groom(bust, **given(strands=200, segments=4))
    assert (everywhere.root_uv[:, 0] < 0.39).mean() > 0.5, "most hair would grow where the picture is dark"
    with pytest.raises(BadInput, match="has no map 'beard'"):
        grow_groom(bust, **given(density={"map": "beard"}))


@pytest.mark.parametrize("style", [{}, {"curl": {"radius": 0.015, "pitch": 0.03}}], ids=["straight", "curly"])
def test_no_hair_grows_through_a_bust_that_is_open_where_it_ends(bust: Body, style: dict[str, object]) -> None:
    x, y, z = bust.mesh.points.T
    lowest = y.min() + 0.04
    mouth = (np.abs(x) < 0.02) & (z > 0.08) & (np.abs(y - 0.23) < 0.02)
    gone = (y < lowest) | (np.abs(x) > 0.17) | mouth
    triangles = bust.mesh.triangles
    kept = ~gone[triangles].any(axis=1)
    uv = None if bust.mesh.uv is None else bust.mesh.uv[kept]
    opened = replace(bust, mesh=Mesh(bust.mesh.points, triangles[kept], uv=uv))
    groom = grow_groom(opened, **given(strands=150, length=0.5, segments=60, **style))
    whole, roots = solid_of(bust.mesh), groom.offsets[:-1]
    points = np.delete(groom.points, roots, axis=0)
    around = points[(points[:, 1] > lowest + 0.005) & (np.abs(points[:, 0]) < 0.165)]
    depth = np.array([distance_and_normal(whole, tuple(point), 0)[0] for point in around])
    assert depth.min() > -1e-5, "where the bust is, hair is outside it"
    cut = solid_of(closed(opened.mesh))
    assert min(distance_and_normal(cut, tuple(point), 0)[0] for point in points) > 0.0
    lengths = np.linalg.norm(np.diff(groom.points.reshape(len(roots), -1, 3), axis=1), axis=2)
    assert np.allclose(lengths, 0.5 / 60, rtol=1e-9)


def test_no_curl_grows_into_sintel_whose_bust_is_open_at_six_places(shared: Path) -> None:
    with pytest.warns(UserWarning, match="no skeleton to locate its head"):
        sintel = load_body(file=shared / "sintel" / "sintel.obj", scalp=Scalp())
    curl = {"radius": 0.015, "pitch": 0.03}
    groom = grow_groom(sintel, **given(strands=400, length=0.1, segments=25, curl=curl, seed=1))
    points, solid = np.delete(groom.points, groom.offsets[:-1], axis=0), solid_of(closed(sintel.mesh))
    assert min(distance_and_normal(solid, tuple(point), 0)[0] for point in points) > 0.0
