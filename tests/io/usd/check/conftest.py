"""A good stage with everything the lint looks at, and OpenVDB files that are one word a grid."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdVol

from hairpipe.errors import BadInput
from hairpipe.io.usd.check.lint import lint
from hairpipe.io.usd.shot import Shot, write_shot

SKIN, FIELD = "/shot/char/skin", "/shot/volume/surface"


class Grid(NamedTuple):
    name: str
    grid_class: str


def inspect(path: Path) -> list[Grid]:
    """An OpenVDB file for the lint: one word a grid."""
    if path.read_text() == "broken":
        raise BadInput("not an OpenVDB file", where=path)
    return [Grid(name, "level set") for name in path.read_text().split()]


def add_volume(stage: Usd.Stage) -> None:
    volume = UsdVol.Volume.Define(stage, "/shot/volume")
    field = UsdVol.OpenVDBAsset.Define(stage, FIELD)
    field.CreateFieldNameAttr("surface")
    field.CreateFieldClassAttr("levelSet")
    for frame in range(1001, 1006):
        field.CreateFilePathAttr().Set(Sdf.AssetPath(f"./body.{frame}.vdb"), frame)
    volume.CreateFieldRelationship("surface", field.GetPath())
    volume.CreateExtentAttr([Gf.Vec3f(0), Gf.Vec3f(1)])


def add_character(stage: Usd.Stage) -> None:
    UsdSkel.Root.Define(stage, "/shot/char")
    skeleton = UsdSkel.Skeleton.Define(stage, "/shot/char/skeleton")
    skeleton.CreateJointsAttr(["root"])
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)])
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)])
    skin = UsdGeom.Mesh.Define(stage, SKIN)
    skin.CreatePointsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)])
    skin.CreateFaceVertexCountsAttr([3])
    skin.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    skin.CreateFaceVertexIndicesAttr([0, 1, 2])
    skin.CreateExtentAttr([Gf.Vec3f(0), Gf.Vec3f(1, 1, 0)])
    binding = UsdSkel.BindingAPI.Apply(skin.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(True, 1).Set([0])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])


@pytest.fixture
def stage(tmp_path: Path, shot: Shot) -> Usd.Stage:
    """A good shot with a level set, a character and a prop from another file."""
    for frame in range(1001, 1006):
        (tmp_path / f"body.{frame}.vdb").write_text("surface vel")
    prop = Usd.Stage.CreateNew(str(tmp_path / "prop.usda"))
    prop.SetDefaultPrim(UsdGeom.Xform.Define(prop, "/prop").GetPrim())
    prop.Save()
    write_shot(tmp_path / "shot.usdc", shot)
    stage = Usd.Stage.Open(str(tmp_path / "shot.usdc"))
    stage.DefinePrim("/shot/prop").GetReferences().AddReference("./prop.usda")
    add_volume(stage)
    add_character(stage)
    return stage


@pytest.fixture
def found() -> Callable[[Usd.Stage], list[tuple[str, str]]]:
    """Save a stage and say which rules are broken, and where."""

    def check(stage: Usd.Stage) -> list[tuple[str, str]]:
        stage.Save()
        return [(finding.rule, finding.path) for finding in lint(Path(stage.GetRootLayer().realPath), inspect)]

    return check
