"""Planted defects for each row of what Unreal, Houdini and Blender read of hair; what export_groom writes has none."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from hairpipe.engine import Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.usd.curves import read_curves
from hairpipe.nodes.export_groom import export_groom
from hairpipe.values import Groom, Strands
from hairpipe.values.strand_arrays import take
from tests.formats.complete_groom import complete_groom

TYPES, TOKENS = Sdf.ValueTypeNames, UsdGeom.Tokens
STRANDS, POINTS = 30, 6
CLIENTS = ("unreal", "houdini", "blender")


@pytest.fixture(scope="module")
def groom() -> Groom:
    return complete_groom(STRANDS, POINTS)


def moving(groom: Groom) -> Frames[Strands]:
    velocities = np.tile(np.float32([0, 0.024, 0]), (STRANDS * POINTS, 1))
    return Frames(
        (1, 2, 3), lambda f: Strands(groom.points + np.array([0, 0.001 * f, 0]), velocities, groom.offsets, 1e-4)
    )


def written(folder: Path, groom: Groom, target: str) -> Path:
    keys = take(groom, np.arange(0, STRANDS, 5))
    return export_groom(groom, moving(groom), keys, None, None, Time(1, 24.0), Workspace(folder), target=target).path


@pytest.mark.parametrize("target", CLIENTS)
def test_lint_is_silent_on_an_exported_groom(tmp_path, groom, target):
    assert [str(finding) for finding in lint(written(tmp_path, groom, target), None, target)] == []


@pytest.mark.parametrize("target", CLIENTS)
@pytest.mark.filterwarnings("ignore:.*not used", "ignore:.*read at time code")
def test_an_exported_groom_is_read_back(tmp_path, groom, target):
    """In metres with Y up, whatever the unit and the axis of the program."""
    found = read_curves(written(tmp_path, groom, target), time=2.0, guides=True)
    hair, guides = np.flatnonzero(~found.guides), np.flatnonzero(found.guides)
    assert len(hair) == STRANDS and len(guides) == STRANDS // 5
    points = found.points.reshape(-1, POINTS, 3)
    expected = (groom.points + np.array([0, 0.002, 0])).reshape(-1, POINTS, 3)
    assert np.abs(points[hair] - expected).max() < 1e-8 and np.abs(points[guides] - expected[::5]).max() < 1e-8
    assert found.ids[hair].tolist() == groom.ids.tolist() and len(set(found.ids)) == len(found.ids)
    assert np.allclose(found.widths.reshape(-1, POINTS)[hair].ravel(), groom.widths, atol=1e-10)
    assert np.array_equal(found.groups[hair], groom.groups) and found.group_names == groom.group_names
    assert np.allclose(found.root_uv[hair], groom.root_uv)
    assert np.allclose(found.colours.reshape(-1, POINTS, 3)[hair].reshape(-1, 3), groom.colours)


def test_guides_of_another_groom_bring_their_motion(tmp_path, groom):
    keys = take(groom, np.array([3]))
    other = Groom(**{**vars(keys), "ids": np.array([900], np.int32)})
    with pytest.raises(BadInput, match=r"guides are not strands of the groom \(in\.key_hair: their motion\)"):
        export_groom(groom, moving(groom), other, None, None, Time(1, 24.0), Workspace(tmp_path), target="unreal")


def primvar(prim: UsdGeom.BasisCurves, name: str, kind, interpolation: str, value: object) -> None:
    api = UsdGeom.PrimvarsAPI(prim)
    api.RemovePrimvar(name)
    api.CreatePrimvar(name, kind, interpolation).Set(value)


def curves(stage: Usd.Stage) -> UsdGeom.BasisCurves:
    return UsdGeom.BasisCurves(stage.GetPrimAtPath("/groom/hair"))


def count(stage: Usd.Stage) -> int:
    return len(curves(stage).GetCurveVertexCountsAttr().Get())


def bound(stage: Usd.Stage) -> None:
    prim = stage.DefinePrim("/groom/binding")
    prim.CreateRelationship("unreal:groomBinding:groom").SetTargets(["/groom/hair"])
    prim.CreateRelationship("unreal:groomBinding:referenceMesh").SetTargets(["/nowhere"])


UNIFORM, VERTEX = TOKENS.uniform, TOKENS.vertex
ONE = Gf.Vec3f(1)
DEFECTS = {
    "no schema": ("unreal", lambda s: curves(s).GetPrim().ClearMetadata("apiSchemas"), "unreal-schema", "GroomAPI"),
    "colour": (
        "unreal",
        lambda s: primvar(curves(s), "groom_color", TYPES.Color3fArray, UNIFORM, [ONE] * count(s)),
        "unreal-primvar",
        r"is color3f\[\], which unreal ignores",
    ),
    "guides as integers": (
        "unreal",
        lambda s: primvar(curves(s), "groom_closest_guides", TYPES.Int3Array, UNIFORM, [Gf.Vec3i(35)] * count(s)),
        "unreal-primvar",
        r"is int3\[\], which unreal ignores",
    ),
    "half": (
        "unreal",
        lambda s: primvar(curves(s), "groom_own", TYPES.HalfArray, UNIFORM, [0.5] * count(s)),
        "unreal-primvar",
        r"is half\[\], which unreal ignores",
    ),
    "bytes": (
        "unreal",
        lambda s: primvar(curves(s), "groom_group_id", TYPES.UCharArray, UNIFORM, Vt.UCharArray(count(s), 1)),
        "unreal-primvar",
        r"is uchar\[\], which unreal ignores",
    ),
    "no prefix": (
        "unreal",
        lambda s: primvar(curves(s), "group_id", TYPES.IntArray, UNIFORM, [1] * count(s)),
        "unreal-primvar",
        "does not begin with groom_",
    ),
    "other count": (
        "unreal",
        lambda s: primvar(curves(s), "groom_group_id", TYPES.IntArray, UNIFORM, [1] * (count(s) - 1)),
        "unreal-primvar",
        "has 35 values, which unreal skips; uniform takes 36",
    ),
    "interpolation": (
        "unreal",
        lambda s: primvar(curves(s), "groom_root_uv", TYPES.Float2Array, VERTEX, [Gf.Vec2f(0)] * (6 * count(s))),
        "unreal-primvar",
        "is vertex, which unreal ignores",
    ),
    "varying widths": ("unreal", lambda s: curves(s).SetWidthsInterpolation("varying"), "unreal-widths", "is varying"),
    "no widths": ("unreal", lambda s: curves(s).GetPrim().RemoveProperty("widths"), "unreal-widths", "one centimetre"),
    "B-spline": ("unreal", lambda s: curves(s).GetBasisAttr().Set("bspline"), "unreal-basis", "is bspline"),
    "all guides": (
        "unreal",
        lambda s: primvar(curves(s), "groom_guide", TYPES.IntArray, UNIFORM, [1] * count(s)),
        "unreal-guides",
        "marks all strands as guides",
    ),
    "lost guide": (
        "unreal",
        lambda s: primvar(curves(s), "groom_closest_guides", TYPES.Float3Array, UNIFORM, [Gf.Vec3f(7)] * count(s)),
        "unreal-guides",
        "names the guide 7",
    ),
    "binding": ("unreal", bound, "unreal-binding", "has no target"),
    "no rest": (
        "houdini",
        lambda s: curves(s).GetPrim().RemoveProperty("primvars:rest"),
        "houdini-primvar",
        "primvars:rest: has no value",
    ),
    "rest as colour": (
        "houdini",
        lambda s: primvar(curves(s), "rest", TYPES.Color3fArray, VERTEX, [ONE] * (6 * count(s))),
        "houdini-primvar",
        "which houdini ignores",
    ),
    "control points": ("blender", lambda s: curves(s).GetBasisAttr().Set("bspline"), "blender-basis", "is bspline"),
    "uniform widths": (
        "blender",
        lambda s: curves(s).SetWidthsInterpolation(UNIFORM),
        "blender-widths",
        "is uniform, which blender ignores",
    ),
}


@pytest.mark.parametrize(("target", "plant", "rule", "message"), DEFECTS.values(), ids=DEFECTS)
def test_a_planted_defect_is_found(tmp_path, groom, target, plant, rule, message):
    path = written(tmp_path, groom, target)
    stage = Usd.Stage.Open(str(path))
    plant(stage)
    stage.Export(str(tmp_path / "bad.usda"))
    found = [str(finding) for finding in lint(tmp_path / "bad.usda", None, target)]
    import re

    assert any(f" {rule}: " in line and re.search(message, line) for line in found), found
    assert not any(f" {rule}: " in str(finding) for finding in lint(tmp_path / "bad.usda"))
