"""A shot says what it was given, exactly, at every frame, in the conventions that renderers agree on."""

import dataclasses
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade

from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.usd.curves import STEPS, read_curves
from hairpipe.formats.usd.meshes import read_body
from hairpipe.formats.usd.shot import Shot, write_clips, write_shot, write_still
from hairpipe.formats.vdb import inspect
from hairpipe.groom.resampling import spline_knots
from hairpipe.values import Mesh
from hairpipe.values.hair import FOLLOWER, GUIDE, HairState, LockState, no_locks

TOKENS = UsdGeom.Tokens


@pytest.fixture(params=[write_shot, write_clips], ids=["single", "clips"])
def write(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[[Shot], Path]:
    """Write a shot in one layout or the other."""

    def to_file(shot: Shot) -> Path:
        request.param(tmp_path / "shot.usdc", shot)
        return tmp_path / "shot.usdc"

    return to_file


class Opened:
    """A stage, held open, with its hair and body."""

    def __init__(self, path: Path) -> None:
        self.stage = Usd.Stage.Open(str(path))
        self.hair = UsdGeom.BasisCurves(self.stage.GetPrimAtPath("/shot/hair"))
        self.body = UsdGeom.Mesh(self.stage.GetPrimAtPath("/shot/body"))


def test_every_frame_holds_what_was_given(write, shot: Shot) -> None:
    opened = Opened(write(shot))
    hair, body = opened.hair, opened.body
    for frame in shot.hair:
        strands, mesh = shot.hair[frame], shot.body[frame]
        np.testing.assert_array_equal(hair.GetPointsAttr().Get(frame), strands.points)
        np.testing.assert_array_equal(hair.GetVelocitiesAttr().Get(frame), strands.velocities)
        np.testing.assert_array_equal(body.GetPointsAttr().Get(frame), mesh.points.astype(np.float32))
        np.testing.assert_array_equal(body.GetVelocitiesAttr().Get(frame), mesh.velocities.astype(np.float32))
    assert hair.GetPointsAttr().GetTimeSamples() == body.GetPointsAttr().GetTimeSamples() == list(shot.hair)


def test_which_hair_follows_which_is_written_at_every_frame(write, shot: Shot) -> None:
    alone = no_locks(len(shot.groom.ids))
    leads = {frame: np.roll([0, 0, 2, 3, 3, 3], k).astype(np.int32) for k, frame in enumerate(shot.hair)}
    states = {}
    for frame, guides in leads.items():
        roles = np.where(guides == np.arange(6), GUIDE, FOLLOWER)
        states[frame] = state_of(dataclasses.replace(alone, roles=roles, guides=guides))
    states[1002], leads[1002] = state_of(None), np.arange(6)
    opened = Opened(write(dataclasses.replace(shot, states=states)))
    written = UsdGeom.PrimvarsAPI(opened.hair).GetPrimvar("lockId")
    assert written.GetInterpolation() == TOKENS.uniform
    for frame, now in leads.items():
        np.testing.assert_array_equal(written.Get(frame), shot.groom.ids[now])
    np.testing.assert_array_equal(written.Get(), shot.groom.ids[leads[1001]])


def test_states_of_other_hair_are_refused(write, shot: Shot) -> None:
    states = dict.fromkeys(shot.hair, state_of(no_locks(4)))
    with pytest.raises(BadInput, match="states are not those of the hair"):
        write(dataclasses.replace(shot, states=states))


def state_of(locks: LockState | None) -> HairState:
    """A state of which nothing but the locks is looked at."""
    return HairState(*[np.empty(0)] * 8, pace=np.inf, stretched=1.0, locks=locks)


def test_times_between_are_blended_and_times_outside_held(write, shot: Shot) -> None:
    opened = Opened(write(shot))
    points = opened.hair.GetPointsAttr()
    middle = (shot.hair[1002].points + shot.hair[1003].points) / 2
    np.testing.assert_allclose(points.Get(1002.5), middle, atol=1e-7)
    np.testing.assert_array_equal(points.Get(1), shot.hair[1001].points)
    np.testing.assert_array_equal(points.Get(2000), shot.hair[1005].points)


def test_default_values_are_the_first_frame(write, shot: Shot) -> None:
    """Without a time there are points and boxes, in clips too, where they must not hide those of the frames."""
    opened = Opened(write(shot))
    assert opened.stage.GetPrimAtPath("/shot").IsDefined()
    for shape, first in ((opened.hair, shot.hair[1001]), (opened.body, shot.body[1001])):
        np.testing.assert_array_equal(shape.GetPointsAttr().Get(), first.points.astype(np.float32))
        np.testing.assert_array_equal(shape.GetExtentAttr().Get(), shape.GetExtentAttr().Get(1001))
    np.testing.assert_array_equal(opened.body.GetNormalsAttr().Get(), opened.body.GetNormalsAttr().Get(1001))
    assert not np.array_equal(opened.hair.GetPointsAttr().Get(1004), opened.hair.GetPointsAttr().Get())


def test_the_colour_of_hair_outlives_its_material(write, shot: Shot) -> None:
    """Some clients drop the materials of curves: what is seen then is displayColor, which is that of the material."""
    opened = Opened(write(shot))
    for prim in (opened.hair, opened.body):
        binding = UsdShade.MaterialBindingAPI(prim).GetDirectBinding()
        assert binding.GetMaterialPurpose() == UsdShade.Tokens.allPurpose
        shader, _, _ = binding.GetMaterial().ComputeSurfaceSource()
        assert [shader.GetInput("diffuseColor").Get()] == list(prim.GetDisplayColorAttr().Get())
        assert prim.GetDisplayColorPrimvar().GetInterpolation() == TOKENS.constant


def test_normals_are_perpendicular_to_a_flat_patch(write, shot: Shot) -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, -1], [0, 0, -1], [9, 9, 9]])
    flat = Mesh(square, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    opened = Opened(write(dataclasses.replace(shot, body=dict.fromkeys(shot.hair, flat))))
    body = opened.body
    np.testing.assert_allclose(body.GetNormalsAttr().Get(1001), [[0, 1, 0]] * 4 + [[0, 0, 0]])
    assert body.GetNormalsInterpolation() == TOKENS.vertex and not body.GetVelocitiesAttr().HasValue()


def test_points_may_be_the_control_hull_of_b_splines_from_root_to_tip(write, shot: Shot) -> None:
    waves = np.tile(0.01 * np.sin(np.arange(5.0))[:, None], (6, 3)).astype(np.float32)  # 0 at the roots
    flat = {f: shot.hair[f] for f in shot.hair}
    bent = {f: dataclasses.replace(h, points=h.points + waves) for f, h in flat.items()}
    path = write(dataclasses.replace(shot, hair=bent, curve="bspline"))
    hull, offsets = bent[1001].points, bent[1001].offsets
    knots = read_curves(path, "/shot/hair").points.reshape(len(offsets) - 1, -1, 3)[:, ::STEPS].reshape(-1, 3)
    np.testing.assert_allclose(knots, spline_knots(hull, offsets), atol=1e-7)
    for ends in (offsets[:-1], offsets[1:] - 1):
        np.testing.assert_allclose(knots[ends], hull[ends], atol=1e-7)
    assert np.abs(knots - hull).max() > 1e-4
    [finding] = lint(path, inspect)
    assert (finding.rule, finding.path) == ("hair-basis", "/shot/hair.basis")
    assert f"passes them at up to {np.linalg.norm(knots - hull, axis=1).max():.2g}," in finding.message


def test_hair_follows_the_conventions(write, shot: Shot) -> None:
    opened = Opened(write(shot))
    hair = opened.hair
    assert hair.GetTypeAttr().Get() == TOKENS.cubic and hair.GetBasisAttr().Get() == TOKENS.catmullRom
    assert hair.GetWrapAttr().Get() == TOKENS.pinned and hair.GetWidthsInterpolation() == TOKENS.vertex
    assert list(hair.GetCurveVertexCountsAttr().Get()) == [5] * 6
    np.testing.assert_array_equal(hair.GetWidthsAttr().Get(), np.full(30, 8e-5, np.float32))
    primvars, groom = UsdGeom.PrimvarsAPI(hair), shot.groom
    expected = {
        "pref": (TOKENS.vertex, groom.points.astype(np.float32)),
        "hairId": (TOKENS.uniform, groom.ids),
        "st": (TOKENS.uniform, groom.root_uv),
        "skinprim": (TOKENS.uniform, groom.root_triangles),
        "skinprimuv": (TOKENS.uniform, groom.root_barycentrics[:, 1:].astype(np.float32)),
    }
    for name, (interpolation, value) in expected.items():
        primvar = primvars.GetPrimvar(name)
        assert primvar.GetInterpolation() == interpolation
        np.testing.assert_array_equal(primvar.Get(), value)


def test_the_stage_follows_the_conventions(write, shot: Shot) -> None:
    opened = Opened(write(shot))
    stage = opened.stage
    assert stage.GetDefaultPrim().GetPath() == "/shot"
    assert UsdGeom.GetStageUpAxis(stage) == "Y" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 24
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1001, 1005)
    model = Usd.ModelAPI(stage.GetDefaultPrim())
    assert model.GetKind() == "component" and model.GetAssetName() == "shot"
    assert stage.GetRootLayer().customLayerData["hairpipe"]["version"]
    for prim in (opened.hair, opened.body):
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
        assert material.ComputeSurfaceSource()[0].GetShaderId() == "UsdPreviewSurface"


def test_reads_back_to_the_same_groom_and_body(write, shot: Shot) -> None:
    path = write(shot)
    found = read_curves(path, None)
    np.testing.assert_array_equal(found.points.astype(np.float32), shot.hair[1001].points)
    np.testing.assert_array_equal(found.offsets, shot.groom.offsets)
    np.testing.assert_array_equal(found.ids, shot.groom.ids)
    np.testing.assert_allclose(found.rest, shot.groom.points, atol=1e-7)
    np.testing.assert_allclose(found.widths, shot.hair[1001].diameter)
    mesh, first = read_body(path, None).mesh, shot.body[1001]
    np.testing.assert_allclose(mesh.points, first.points, atol=1e-8)
    np.testing.assert_array_equal(mesh.triangles, first.triangles)
    np.testing.assert_array_equal(mesh.uv, first.uv)


def test_widths_of_a_file_go_out_again_and_extents_have_room_for_them(write, shot: Shot) -> None:
    widths = np.linspace(1e-4, 5e-3, len(shot.groom.points))
    opened = Opened(write(dataclasses.replace(shot, groom=dataclasses.replace(shot.groom, widths=widths))))
    np.testing.assert_allclose(opened.hair.GetWidthsAttr().Get(), widths, rtol=1e-6)
    lower, upper = np.array(opened.hair.GetExtentAttr().Get(1002))
    points = shot.hair[1002].points
    np.testing.assert_allclose([lower, upper], [points.min(axis=0) - 2.5e-3, points.max(axis=0) + 2.5e-3], atol=1e-7)


@pytest.mark.parametrize("hairs", [120, 600])  # 600 are drawn 8 mm wide
def test_our_check_is_silent_on_strands_that_represent_many_hairs(write, shot: Shot, hairs: int) -> None:
    assert [str(finding) for finding in lint(write(dataclasses.replace(shot, hairs=hairs)))] == []


@pytest.mark.parametrize("tapered", [False, True])
def test_strands_that_represent_many_hairs_are_drawn_wide(write, shot, tapered) -> None:
    """The widths are hairs / strands times the diameters up to .65 of a strand, and fall to 0 at its tip."""
    along = np.tile(np.linspace(8e-5, 4e-5, 5), 6) if tapered else np.full(30, 8e-5)
    groom = dataclasses.replace(shot.groom, widths=along if tapered else None)
    path = write(dataclasses.replace(shot, groom=groom, hairs=120))
    opened = Opened(path)
    widths = np.array(opened.hair.GetWidthsAttr().Get()).reshape(6, 5)
    np.testing.assert_allclose(widths[:, :3], 20.0 * along.reshape(6, 5)[:, :3], rtol=1e-6)
    assert (widths[:, 4] == 0.0).all() and (widths[:, 3] > 0.0).all() and (widths[:, 3] < widths[:, 2]).all()
    np.testing.assert_allclose(UsdGeom.PrimvarsAPI(opened.hair).GetPrimvar("hairDiameter").Get(), along, rtol=1e-6)
    np.testing.assert_allclose(read_curves(path, None).widths, along, rtol=1e-6)
    lower, upper = np.array(opened.hair.GetExtentAttr().Get(1002))
    points = shot.hair[1002].points
    np.testing.assert_allclose([lower, upper], [points.min(axis=0) - 8e-4, points.max(axis=0) + 8e-4], atol=1e-7)


def test_strands_are_not_thinner_than_hair(write, shot: Shot) -> None:
    opened = Opened(write(dataclasses.replace(shot, hairs=3)))
    np.testing.assert_allclose(opened.hair.GetWidthsAttr().Get(), 8e-5, rtol=1e-6)


def test_hair_alone_is_numbered(write, shot: Shot) -> None:
    opened = Opened(write(dataclasses.replace(shot, body=None, groom=None)))
    primvars = UsdGeom.PrimvarsAPI(opened.hair)
    assert list(primvars.GetPrimvar("hairId").Get()) == list(range(6)) and not opened.body
    assert not primvars.HasPrimvar("pref") and not primvars.HasPrimvar("st")


def test_clips_lie_where_the_file_names_them(tmp_path: Path, shot: Shot) -> None:
    skipping = {frame: shot.hair[frame] for frame in (1001, 1003, 1004)}
    named = write_clips(tmp_path / "a.usdc", dataclasses.replace(shot, hair=skipping, name="take_2"))
    assert sorted(named) == [
        "take_2.clips/take_2.1001.usdc",
        "take_2.clips/take_2.1003.usdc",
        "take_2.clips/take_2.1004.usdc",
        "take_2.clips/take_2.manifest.usdc",
    ]
    moved = tmp_path / "elsewhere"
    for name, file in [*named.items(), ("other.usd", tmp_path / "a.usdc")]:
        (moved / name).parent.mkdir(parents=True, exist_ok=True)
        file.rename(moved / name)
    stage = Usd.Stage.Open(str(moved / "other.usd"))
    points = stage.GetAttributeAtPath("/take_2/hair.points")
    assert points.GetTimeSamples() == [1001, 1003, 1004]
    np.testing.assert_array_equal(points.Get(1003), shot.hair[1003].points)


def at_frame(field: str, frame: int, name: str, change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Shot], Shot]:
    """Plant another array in the hair or the body of one frame."""

    def plant(shot: Shot) -> Shot:
        given = getattr(shot, field)
        value = dataclasses.replace(given[frame], **{name: change(getattr(given[frame], name))})
        return dataclasses.replace(shot, **{field: {f: value if f == frame else given[f] for f in given}})

    return plant


def nan_in(*rows: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda array: np.where(np.isin(np.arange(len(array)), rows)[:, None], np.nan, array)


def with_groom(shot: Shot) -> Shot:
    return dataclasses.replace(shot, groom=dataclasses.replace(shot.groom, offsets=shot.groom.offsets[:-1]))


BROKEN: list[tuple[str, Callable[[Shot], Shot]]] = [
    ("hair at frame 1003: points of strands 1, 5 are not", at_frame("hair", 1003, "points", nan_in(7, 8, 29))),
    ("hair at frame 1002: velocities of strand 0 are not", at_frame("hair", 1002, "velocities", nan_in(0))),
    ("points of strands 0, 1, 2, 3, 4 and 1 more are not", at_frame("hair", 1002, "points", nan_in(*range(30)))),
    ("body at frame 1004: points of vertices 2 are not finite", at_frame("body", 1004, "points", nan_in(2))),
    ("hair at frame 1005: the strands are not those of", at_frame("hair", 1005, "offsets", lambda o: o[::-1])),
    ("body at frame 1005: the triangles are not those of", at_frame("body", 1005, "triangles", lambda t: t[::-1])),
    ("groom: the groom does not have the strands", with_groom),
    ("hair: there are no frames to export", lambda s: dataclasses.replace(s, hair={})),
    ("name: '1 b' cannot name a prim", lambda s: dataclasses.replace(s, name="1 b")),
]


@pytest.mark.parametrize(("message", "plant"), BROKEN, ids=[message for message, _ in BROKEN])
def test_invalid_samples_are_refused(write, shot: Shot, message: str, plant: Callable[[Shot], Shot]) -> None:
    with pytest.raises(BadInput, match=message):
        write(plant(shot))


SCRIPT = """
import hashlib, sys
from pathlib import Path
import numpy as np
from hairpipe.values import Strands
from hairpipe.formats.usd.shot import Shot, write_clips, write_shot

class Wave(dict):
    def __getitem__(self, frame):
        points = np.full((80_000, 3), frame, np.float32) + np.arange(240_000, dtype=np.float32).reshape(-1, 3)
        return Strands(points, points, np.arange(0, 80_001, 20, dtype=np.int32), 8e-5)

layout, count, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
folder.mkdir()
write = {"single": write_shot, "clips": write_clips}[layout]
write(folder / "shot.usdc", Shot(Wave.fromkeys(range(count)), None, None, 24))
data = b"".join(file.read_bytes() for file in sorted(folder.rglob("*.usdc"))) if len(sys.argv) < 5 else b""
peak = Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]  # ru_maxrss begins with the parent's
print(peak if len(sys.argv) > 4 else hashlib.sha256(data).hexdigest())
"""


def run(*words: object, **environment: str) -> str:
    command = [sys.executable, "-c", SCRIPT, *map(str, words)]
    return subprocess.run(command, check=True, capture_output=True, text=True, env={**os.environ, **environment}).stdout


@pytest.mark.parametrize("layout", ["single", "clips"])
def test_same_shot_same_bytes(tmp_path: Path, layout: str) -> None:
    digests = {run(layout, 3, tmp_path / seed, PYTHONHASHSEED=seed) for seed in ("1", "2")}
    assert len(digests) == 1


@pytest.mark.parametrize("layout", ["single", "clips"])
def test_memory_does_not_grow_with_the_shot(tmp_path: Path, layout: str) -> None:
    """Of 1.9 MB a frame, 80 more frames would be 150 MB; USD itself keeps 0.15 MB a layer, whatever its size."""
    few, many = (int(run(layout, count, tmp_path / str(count), "memory")) for count in (30, 110))
    assert many - few < 50_000


@pytest.fixture(params=["hair", "body", "groom"])
def value(request, shot):
    return shot.groom if request.param == "groom" else getattr(shot, request.param)[1003]


def test_our_strict_check_finds_nothing(value, tmp_path):
    write_still(tmp_path / "still.usda", value, 1003, 24.0)
    assert lint(tmp_path / "still.usda", lambda path: []) == []


def test_the_points_stand_at_the_one_frame(value, tmp_path):
    write_still(tmp_path / "still.usdc", value, 1003, 24.0)
    stage = Usd.Stage.Open(str(tmp_path / "still.usdc"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (1003, 1003, 24)
    (prim,) = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointBased)]
    attribute = UsdGeom.PointBased(prim).GetPointsAttr()
    assert attribute.GetTimeSamples() == [1003]
    np.testing.assert_array_equal(attribute.Get(1003), np.float32(value.points))
