"""What a shot is put together from: clips, layers and references are those they should be, or the defect is named."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from hairpipe.formats.usd.check.lint import lint

HAIR, FRAMES = "/shot/hair", range(1001, 1009)
Plant = Callable[[Usd.Stage], object]


def folder(stage: Usd.Stage) -> Path:
    return Path(stage.GetRootLayer().realPath).parent


def set_clips(**fields: object) -> Plant:
    """Plant other metadata of the clips; None takes a field away."""

    def plant(stage: Usd.Stage) -> None:
        api = Usd.ClipsAPI(stage.GetDefaultPrim())
        changed = {**api.GetClips()["default"], **fields}
        api.SetClips({"default": {name: value for name, value in changed.items() if value is not None}})

    return plant


def undeclared(stage: Usd.Stage) -> None:
    layer = Sdf.Layer.FindOrOpen(str(folder(stage) / "shot.clips" / "shot.manifest.usdc"))
    hair = layer.GetPrimAtPath(HAIR)
    hair.RemoveProperty(hair.properties["velocities"])
    layer.Save()


def files(*names: str) -> Sdf.AssetPathArray:
    return Sdf.AssetPathArray([Sdf.AssetPath(name) for name in names])


CLIP = [f"./shot.clips/shot.{frame}.usdc" for frame in FRAMES]
CLIPS: dict[str, tuple[Plant, str]] = {
    "manifest without velocities": (undeclared, "clip-undeclared velocities"),
    "two clips swapped": (set_clips(assetPaths=files(CLIP[1], CLIP[0], *CLIP[2:])), "clip-times"),
    "clip left out": (set_clips(assetPaths=files(*CLIP[:3], *CLIP[4:])), "clip-times"),
    "clip one late": (set_clips(active=Vt.Vec2dArray([(f + 1, i) for i, f in enumerate(FRAMES)])), "clip-times"),
    "clip never played": (set_clips(active=Vt.Vec2dArray([(f, 0) for f in FRAMES])), "clip-times"),
    "another prim": (set_clips(primPath="/take"), "clip-undeclared"),
    "above the folder": (
        set_clips(manifestAssetPath=Sdf.AssetPath("../all/shot.clips/shot.manifest.usdc")),
        "absolute-path",
    ),
}


@pytest.mark.parametrize(("plant", "rules"), CLIPS.values(), ids=CLIPS)
def test_names_defects_of_clips(clips: Usd.Stage, found: Callable, plant: Plant, rules: str) -> None:
    plant(clips)
    assert set(rules.split()) <= {rule for rule, _ in found(clips)}


def test_silent_on_clips_and_on_what_they_flatten_to(clips: Usd.Stage, found: Callable, tmp_path: Path) -> None:
    assert found(clips) == []
    clips.Flatten().Export(str(tmp_path / "flat.usda"))
    assert lint(tmp_path / "flat.usda") == []


def layer(name: str, **facts: object) -> Plant:
    """Plant a sublayer that says these things of itself."""

    def plant(stage: Usd.Stage) -> None:
        made = Usd.Stage.CreateNew(str(folder(stage) / name))
        for fact, value in facts.items():
            made.SetMetadata(fact, value)
        made.DefinePrim("/shot")
        made.Save()
        stage.GetRootLayer().subLayerPaths.append(f"./{name}")

    return plant


def refer(path: str, target: str = "") -> Plant:
    """Plant a reference to a prim of a file that has none of it."""

    def plant(stage: Usd.Stage) -> None:
        made = Usd.Stage.CreateNew(str(folder(stage) / "prop.usda"))
        made.DefinePrim("/prop")
        made.Save()
        stage.DefinePrim(path).GetReferences().AddReference("./prop.usda", target)

    return plant


def choose(stage: Usd.Stage) -> None:
    variants = stage.GetDefaultPrim().GetVariantSets().AddVariantSet("look")
    variants.AddVariant("wet")
    variants.SetVariantSelection("dry")


def guide(stage: Usd.Stage) -> None:
    Sdf.CopySpec(stage.GetRootLayer(), HAIR, stage.GetRootLayer(), "/shot/guides")
    UsdGeom.Imageable(stage.GetPrimAtPath("/shot/guides")).CreatePurposeAttr("guide")


def scatter(stage: Usd.Stage) -> None:
    UsdGeom.PointInstancer.Define(stage, "/shot/scatter").CreatePrototypesRel().SetTargets([HAIR])


def turn_rest(stage: Usd.Stage) -> None:
    attribute = stage.GetAttributeAtPath(f"{HAIR}.primvars:pref")
    attribute.Set(Vt.Vec3fArray.FromNumpy(np.array(attribute.Get()).reshape(30, -1, 3)[:, ::-1].reshape(-1, 3).copy()))


def retype(stage: Usd.Stage) -> None:
    shader = stage.GetPrimAtPath("/shot/Looks/hair/surface")
    shader.RemoveProperty("inputs:roughness")
    shader.CreateAttribute("inputs:roughness", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.4))


LAYERS: dict[str, tuple[Plant, str]] = {
    "another unit": (layer("cm.usda", metersPerUnit=0.01), "layer-units"),
    "another up": (layer("z.usda", upAxis="Z"), "layer-units"),
    "another rate": (layer("rate.usda", timeCodesPerSecond=30.0), "layer-units"),
    "no such prim": (refer("/shot/prop", "/prop/hair"), "composition"),
    "no default prim": (refer("/shot/prop"), "composition"),
    "no such variant": (choose, "variant"),
    "scattered": (scatter, "instanced-hair"),
    "another kind of curves": (lambda s: s.GetPrimAtPath(HAIR).SetTypeName("NurbsCurves"), "hair-drawn"),
    "rest upside down": (turn_rest, "rest"),
    "input of another type": (retype, "shader-input"),
    "backslashes": (
        lambda s: s.DefinePrim("/shot/prop").GetPayloads().AddPayload(".\\prop.usda"),
        "missing-file absolute-path",
    ),
}


@pytest.mark.parametrize(("plant", "rules"), LAYERS.values(), ids=LAYERS)
def test_names_defects_of_layers(head: Usd.Stage, found: Callable, plant: Plant, rules: str) -> None:
    plant(head)
    assert {rule for rule, _ in found(head)} == set(rules.split())


def scale_to_centimetres(stage: Usd.Stage) -> None:
    """Plant a stage in centimetres, whose content in metres is scaled as a whole."""
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.Xformable(stage.GetDefaultPrim()).AddScaleOp().Set(Gf.Vec3f(100))


def lie_down(stage: Usd.Stage) -> None:
    """Plant a stage with Z up, in which the head is turned upright."""
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.Xformable(stage.GetDefaultPrim()).AddRotateXOp().Set(90)


GOOD: dict[str, Plant] = {
    "as it is": lambda s: None,
    "hair alone, of another program": lambda s: (
        s.RemovePrim("/shot/body"),
        s.GetRootLayer().ClearCustomLayerData(),
    ),
    "far away, by a translate in double precision": lambda s: (
        UsdGeom.Xformable(s.GetDefaultPrim()).AddTranslateOp().Set(Gf.Vec3d(1e5, 0, -3e4))
    ),
    "centimetres": scale_to_centimetres,
    "Z up": lie_down,
    "guides beside": guide,
    "constant width": lambda s: (
        s.GetAttributeAtPath(f"{HAIR}.widths").Set([8e-5]),
        UsdGeom.Curves(s.GetPrimAtPath(HAIR)).SetWidthsInterpolation("constant"),
    ),
    "thin tips": lambda s: s.GetAttributeAtPath(f"{HAIR}.widths").Set([8e-5, 8e-5, 7e-5, 6e-5, 3e-5, 0] * 30),
    "no groom": lambda s: [
        s.GetPrimAtPath(HAIR).RemoveProperty(f"primvars:{n}") for n in ("pref", "st", "skinprim", "skinprimuv")
    ],
}


@pytest.mark.parametrize("change", GOOD.values(), ids=GOOD)
def test_silent_on_good_heads(head: Usd.Stage, found: Callable, change: Plant) -> None:
    change(head)
    assert found(head) == []
