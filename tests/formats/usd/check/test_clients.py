"""Planted defects for each row of what Unreal, Houdini and Blender read of hair; what export_groom writes has none."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from hairpipe.app.cli.commands import files
from hairpipe.engine import Frames, Time, Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.clients import PROGRAMS, UNSHOWN, Unshown
from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.usd.curves import read_curves
from hairpipe.nodes.export_groom import export_groom
from hairpipe.values import Groom, Strands
from hairpipe.values.strand_arrays import take
from tests.formats.complete_groom import complete_groom

TYPES = Sdf.ValueTypeNames
Plant = Callable[[Usd.Stage], object]
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
    found = lint(written(tmp_path, groom, target), None, (target,))
    assert [str(finding) for finding in found if finding.severity != "note"] == []


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


def hair_of(stage: Usd.Stage) -> UsdGeom.BasisCurves:
    return UsdGeom.BasisCurves(stage.GetPrimAtPath("/groom/hair"))


def primvar(name: str, kind: Sdf.ValueTypeName, value: object, interpolation: str = "uniform", short: int = 0) -> Plant:
    """Plant a primvar of one value for all curves or points, in place of the one of its name."""

    def plant(stage: Usd.Stage) -> None:
        api, count = UsdGeom.PrimvarsAPI(hair_of(stage)), len(hair_of(stage).GetCurveVertexCountsAttr().Get())
        api.RemovePrimvar(name)
        values = [value] * (count * (POINTS if interpolation == "vertex" else 1) - short)
        api.CreatePrimvar(name, kind, interpolation).Set(values)

    return plant


def basis(stage: Usd.Stage) -> None:
    hair_of(stage).GetBasisAttr().Set("bspline")


def widths(interpolation: str) -> Plant:
    return lambda stage: hair_of(stage).SetWidthsInterpolation(interpolation)


def remove(name: str) -> Plant:
    return lambda stage: hair_of(stage).GetPrim().RemoveProperty(name)


def unschemed(stage: Usd.Stage) -> None:
    hair_of(stage).GetPrim().ClearMetadata("apiSchemas")


def bound(stage: Usd.Stage) -> None:
    prim = stage.DefinePrim("/groom/binding")
    prim.CreateRelationship("unreal:groomBinding:groom").SetTargets(["/groom/hair"])
    prim.CreateRelationship("unreal:groomBinding:referenceMesh").SetTargets(["/nowhere"])


def hair_of_a_shot(stage: Usd.Stage) -> UsdGeom.BasisCurves:
    return UsdGeom.BasisCurves(stage.GetPrimAtPath("/shot/hair"))


def of_purpose(purpose: str) -> Plant:
    return lambda stage: UsdGeom.Cube.Define(stage, f"/shot/{purpose}").CreatePurposeAttr(purpose)


def prepare(row: Unshown, stage: Usd.Stage) -> None:
    """Give the hair what a program does not show."""
    if row.attribute == "purpose":
        of_purpose(row.value)(stage)
    elif row.attribute == "widths":
        hair_of_a_shot(stage).SetWidthsInterpolation(row.value)


@pytest.mark.parametrize("row", UNSHOWN, ids=lambda row: f"{row.program} {row.attribute} {row.value}")
def test_unshown_data_are_noted_with_a_source(head, row):
    prepare(row, head)
    head.Save()
    file = Path(head.GetRootLayer().realPath)
    place = f"/shot/{row.value}" if row.attribute == "purpose" else f"/shot/hair.{row.attribute}"
    notes = [f for f in lint(file, None, (row.program,)) if f.rule == f"{row.program}-unshown" and f.path == place]
    assert any(row.message in note.message and row.source in note.message for note in notes)
    assert all(note.severity == "note" and note.cause is None for note in notes)


def test_the_command_offers_every_program():
    assert sorted(files.PROGRAMS) == sorted(PROGRAMS)


ONE, UV = Gf.Vec3f(1), Gf.Vec2f(0)
DEFECTS: list[tuple[str, str, Plant]] = [
    ("unreal-schema", "GroomAPI", unschemed),
    ("unreal-primvar", r"is color3f\[\], which unreal ignores", primvar("groom_color", TYPES.Color3fArray, ONE)),
    ("unreal-primvar", r"int3\[\], which unreal", primvar("groom_closest_guides", TYPES.Int3Array, Gf.Vec3i(35))),
    ("unreal-primvar", r"is half\[\], which unreal ignores", primvar("groom_own", TYPES.HalfArray, 0.5)),
    ("unreal-primvar", r"is uchar\[\], which unreal ignores", primvar("groom_group_id", TYPES.UCharArray, 1)),
    ("unreal-primvar", "does not begin with groom_", primvar("group_id", TYPES.IntArray, 1)),
    (
        "unreal-primvar",
        "has 35 values, which unreal skips; uniform takes 36",
        primvar("groom_group_id", TYPES.IntArray, 1, short=1),
    ),
    ("unreal-primvar", "is vertex, which unreal", primvar("groom_root_uv", TYPES.Float2Array, UV, "vertex")),
    ("unreal-widths", "is varying", widths("varying")),
    ("unreal-widths", "one centimetre", remove("widths")),
    ("unreal-basis", "is bspline", basis),
    ("unreal-guides", "marks all strands as guides", primvar("groom_guide", TYPES.IntArray, 1)),
    ("unreal-guides", "names the guide 7", primvar("groom_closest_guides", TYPES.Float3Array, Gf.Vec3f(7))),
    ("unreal-binding", "has no target", bound),
    ("houdini-primvar", "primvars:rest: has no value", remove("primvars:rest")),
    ("houdini-primvar", "which houdini ignores", primvar("rest", TYPES.Color3fArray, ONE, "vertex")),
    ("blender-basis", "is bspline", basis),
    ("blender-widths", "is uniform, which blender ignores", widths("uniform")),
]
"""Rules, messages, and plants that break them for a program."""


@pytest.mark.parametrize(("rule", "message", "plant"), DEFECTS)
def test_a_planted_defect_is_found(tmp_path, groom, rule, message, plant):
    target = rule.partition("-")[0]
    stage = Usd.Stage.Open(str(written(tmp_path, groom, target)))
    plant(stage)
    stage.Export(str(tmp_path / "bad.usda"))
    found = [str(finding) for finding in lint(tmp_path / "bad.usda", None, (target,))]
    assert any(f" {rule}: " in line and re.search(message, line) for line in found), found
    assert not any(f" {rule}: " in str(finding) for finding in lint(tmp_path / "bad.usda"))
