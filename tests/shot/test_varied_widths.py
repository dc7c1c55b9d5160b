"""Diameters that vary on their way from the material to pictures, the page and files."""

import json
from dataclasses import replace
from io import BytesIO
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from hairpipe.app.page.playing import Show, send
from hairpipe.app.page.values import WIDTHS, strands_document
from hairpipe.engine import Frames, Time, Workspace
from hairpipe.engine.run.player import Played, Player
from hairpipe.errors import BadInput
from hairpipe.formats.registry import read_strands
from hairpipe.groom.interpolating import clumped, interpolated
from hairpipe.groom.key_weights import weigh_keys
from hairpipe.groom.strands import unbound
from hairpipe.nodes.export_groom import export_groom
from hairpipe.nodes.export_usd import export_usd
from hairpipe.render.camera import Shot as View
from hairpipe.render.film import backdrop
from hairpipe.render.kajiya_kay import shade_hair
from hairpipe.render.portrait import expose_portrait
from hairpipe.shot.settings import Scene
from hairpipe.shot.simulate import start, strands_of
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Diameter, VariedMaterial
from hairpipe.values import Groom, Strands
from hairpipe.values.strand_arrays import take

TAPER = Diameter(80e-6, profile=((0.0, 1.0), (1.0, 0.25)), map="thick")
POINTS = 9


@pytest.fixture
def groom() -> Groom:
    """Four straight strands side by side, thinner from one to the next."""
    lines = [[[0.002 * s, -0.05 * k / (POINTS - 1), 0.0] for k in range(POINTS)] for s in range(4)]
    bare = unbound(np.array(lines), np.tile(np.eye(3, 4), (4, 1, 1)))
    return replace(bare, maps={"thick": np.array([1.0, 0.9, 0.8, 0.7])})


def hair_of(groom, diameter=TAPER):
    return build_hair(groom, VariedMaterial(diameter), "rod")


def still(groom, widths=None, diameter=8e-5):
    return Strands(groom.points, np.zeros_like(groom.points, np.float32), groom.offsets, diameter, widths)


def expected(count=4):
    return np.multiply.outer(80e-6 * np.array([1.0, 0.9, 0.8, 0.7])[:count], np.linspace(1.0, 0.25, POINTS)).ravel()


def test_strands_have_the_diameters_of_their_material(groom, triangle):
    hair = hair_of(groom)
    shown = strands_of(hair, start(hair, triangle(), Scene()))
    np.testing.assert_allclose(shown.widths, expected(), rtol=1e-6)
    assert shown.diameter == pytest.approx(expected().mean())
    plain = hair_of(groom, Diameter(80e-6))
    shown = strands_of(plain, start(plain, triangle(), Scene()))
    assert shown.widths is None and (shown.widths_at_points() == np.float32(80e-6)).all()


def test_interpolated_hair_has_the_widths_of_its_keys(groom):
    """A key its own, a hair amid two keys their mean, with other numbers of points too; clumps keep them."""
    keys = take(groom, np.array([0, 3]))
    widths = expected()[np.repeat([True, False, False, True], POINTS)].astype(np.float32)
    hair, followed = still(keys, widths), weigh_keys(keys, groom, 30.0)
    motions = np.tile(np.eye(3, 4), (4, 1, 1))
    shown = clumped(interpolated(hair, keys, groom, followed, (motions, 0 * motions)), hair, followed, 0.5, 0.2)
    found = shown.widths.reshape(4, POINTS)
    np.testing.assert_array_equal(found[[0, 3]], widths.reshape(2, POINTS))
    shares = np.array([followed.weights[1, followed.keys[1] == k].sum() for k in range(2)])
    np.testing.assert_allclose(found[1], shares / shares.sum() @ widths.reshape(2, POINTS), rtol=1e-5)
    assert interpolated(still(keys), keys, groom, followed, (motions, 0 * motions)).widths is None


def test_a_picture_is_as_much_darker_as_hair_is_thinner(groom):
    """The area of drawn hair is that of its widths: half of it for half the width, along the whole strand."""
    view = View(eye=(0.0, -0.025, 0.3), target=(0.003, -0.025, 0.0), width=160, height=120)
    films = []
    for widths in (None, np.full(36, 8e-5, np.float32), np.full(36, 4e-5, np.float32)):
        films.append(expose_portrait(still(groom, widths), None, view, np.zeros(3), 0.5, shade_hair))
    np.testing.assert_allclose(films[1], films[0], rtol=1e-5)
    covered = [(backdrop(*film.shape[:2]) - film).sum() for film in films]
    assert covered[2] == pytest.approx(0.5 * covered[0], rel=0.05)


def test_the_page_has_widths_only_where_they_vary(groom):
    document, _ = strands_document(still(groom, expected().astype(np.float32)), 10)
    assert document["diameter"] == pytest.approx(80e-6) and WIDTHS < 64
    assert [array["shape"] for array in document["arrays"] if array["name"] == "widths"] == [[36]]
    assert "widths" not in [array["name"] for array in strands_document(still(groom), 10)[0]["arrays"]]


def test_live_play_has_widths_only_where_they_vary(groom):
    widths = expected().astype(np.float32)
    head, body = played(still(groom, widths))
    assert head["diameter"] == pytest.approx(80e-6) and len(body) == 7 * 36
    np.testing.assert_array_equal(np.frombuffer(body[6 * 36 :], np.uint8), np.rint(widths / widths.max() * WIDTHS))
    head, body = played(still(groom))
    assert head["diameter"] == pytest.approx(80e-6) and len(body) == 6 * 36


def played(hair: Strands) -> tuple[dict, bytes]:
    """Head and body of the message of one frame."""
    out = BytesIO()
    frame = Played(1, {"strands": hair}, {"hair": 0.1})
    send(out, cast(Player, SimpleNamespace(advance=lambda: frame)), Show("", "", "", "hair", "strands", 10))
    size, _ = np.frombuffer(out.getvalue()[:8], "<u4").tolist()
    return json.loads(out.getvalue()[8 : 8 + size]), out.getvalue()[8 + size :]


def exported(path):
    stage = Usd.Stage.Open(str(path))
    curves = next(UsdGeom.BasisCurves(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves))
    return np.array(curves.GetWidthsAttr().Get()), curves.GetWidthsInterpolation()


def test_files_have_the_widths_of_the_hair_before_those_of_the_groom(tmp_path, groom):
    wide = replace(groom, widths=np.full(36, 1e-3))
    widths, time = expected().astype(np.float32), Time(1, 24.0)
    for of, hair, right in (
        (wide, still(groom, widths), widths),
        (wide, still(groom), 1e-3),
        (groom, still(groom, diameter=6e-5), 6e-5),
    ):
        frames = Frames((1, 2), lambda f, hair=hair: hair)
        shot, interpolation = exported(
            export_usd(frames, None, of, None, None, None, None, time, (), Workspace(tmp_path)).path
        )
        np.testing.assert_allclose(shot, np.broadcast_to(right, 36), rtol=1e-6)
        assert interpolation == UsdGeom.Tokens.vertex
        path = export_groom(of, frames, None, None, None, time, Workspace(tmp_path), target="houdini").path
        np.testing.assert_allclose(exported(path)[0], np.broadcast_to(right, 36), rtol=1e-6)


def test_maps_of_a_groom_come_back_from_the_file(tmp_path, groom):
    named = replace(groom, maps={"thick": groom.maps["thick"], "of mine": np.arange(4.0)})
    for target in ("unreal", "houdini", "blender"):
        with pytest.warns(UserWarning, match="the map 'of mine' of the groom is written as of_mine"):
            path = export_groom(named, None, None, None, None, Time(1, 24.0), Workspace(tmp_path), target=target).path
        found = read_strands(path, 1.0, "y", None).maps
        np.testing.assert_allclose(found["thick"], groom.maps["thick"], rtol=1e-6)
        np.testing.assert_array_equal(found["of_mine"], np.arange(4.0))
    twice = replace(groom, maps={"groom_guide_weights": np.ones(4), "id": np.ones(4)})
    with pytest.raises(BadInput, match=r"the map 'id' of the groom has the name of another attribute, id"):
        export_groom(twice, None, None, None, None, Time(1, 24.0), Workspace(tmp_path), target="houdini")
