"""Validators of OpenUSD run as rules: under our names where we have one, on one thread, and without false reports."""

import importlib
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from hairpipe.apart import work_apart
from hairpipe.formats.usd.check.lint import lint

HAIR, MATERIAL, SURFACE = "/shot/hair", "/shot/Looks/hair", "/shot/Looks/hair/surface"
BODY, SUBSET = "/shot/body", "/shot/body/scalp"
TYPES = Sdf.ValueTypeNames
Plant = Callable[[Usd.Stage], object]


def bind(name: str, *targets: str) -> Plant:
    """Plant a further binding of the hair."""
    return lambda stage: stage.GetPrimAtPath(HAIR).CreateRelationship(name).SetTargets(targets)


def bind_subset(stage: Usd.Stage) -> None:
    """Plant a subset of faces that has a material, but no family."""
    subset = UsdGeom.Subset.Define(stage, SUBSET)
    subset.CreateIndicesAttr([0, 1])
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(UsdShade.Material(stage.GetPrimAtPath(MATERIAL)))


def name_normals(stage: Usd.Stage) -> None:
    """Plant a normal map of 8 bits, read as a picture of colours."""
    texture = UsdShade.Shader.Define(stage, f"{MATERIAL}/normals")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", TYPES.Asset).Set("./normals.png")
    output = texture.CreateOutput("rgb", TYPES.Float3)
    UsdShade.Shader(stage.GetPrimAtPath(SURFACE)).CreateInput("normal", TYPES.Normal3f).ConnectToSource(output)
    Path(stage.GetRootLayer().realPath).with_name("normals.png").touch()


def retype(stage: Usd.Stage) -> None:
    """Plant a text where the shader reads a number."""
    stage.GetPrimAtPath(SURFACE).RemoveProperty("inputs:roughness")
    stage.GetPrimAtPath(SURFACE).CreateAttribute("inputs:roughness", TYPES.String).Set("rough")


BINDING = f"{HAIR}.material:binding"
NORMALS = "usdShadeValidators:NormalMapTextureValidator"
DEFECTS: dict[str, tuple[Plant, set[tuple[str, str]]]] = {
    "binding of previews to a mesh": (
        bind("material:binding:preview", BODY),
        {("material-binding", f"{BINDING}:preview")},
    ),
    "binding of previews to nothing": (
        bind("material:binding:preview", "/gone"),
        {("dangling-target", f"{BINDING}:preview")},
    ),
    "collection without a material": (
        bind("material:binding:collection:all", BODY),
        {("material-binding", f"{BINDING}:collection:all")},
    ),
    "binding that is an attribute": (
        lambda s: s.GetPrimAtPath(HAIR).CreateAttribute("material:binding:full", TYPES.String).Set(MATERIAL),
        {("material-binding", f"{BINDING}:full")},
    ),
    "roughness in words": (retype, {("shader-input", f"{SURFACE}.inputs:roughness")}),
    "subset of no family": (
        bind_subset,
        {("usdShadeValidators:SubsetMaterialBindFamilyName.MissingFamilyNameOnGeomSubset", SUBSET)},
    ),
    "normal map as colours": (
        name_normals,
        {
            (f"{NORMALS}.InvalidSourceColorSpace", SURFACE),
            (f"{NORMALS}.NonCompliantBiasAndScale", SURFACE),
        },
    ),
}


@pytest.mark.parametrize(("plant", "expected"), DEFECTS.values(), ids=DEFECTS)
def test_names_the_defect_and_nothing_else(
    head: Usd.Stage, found: Callable, plant: Plant, expected: set[tuple[str, str]]
) -> None:
    plant(head)
    assert set(found(head)) == expected


def test_a_type_that_two_layers_disagree_with_is_one_finding(head: Usd.Stage) -> None:
    path = Path(head.GetRootLayer().realPath)
    for name in ("a.usda", "b.usda"):
        layer = Sdf.Layer.CreateNew(str(path.with_name(name)))
        prim = Sdf.CreatePrimInLayer(layer, HAIR)
        Sdf.AttributeSpec(prim, "orientation", TYPES.String)
        layer.Save()
        head.GetRootLayer().subLayerPaths.append(f"./{name}")
    head.Save()
    (finding,) = lint(path)
    assert (finding.rule, finding.path, finding.count) == ("attribute-type", f"{HAIR}.orientation", 2)
    assert "'token'" in finding.message and "'string'" in finding.message


def shade_elsewhere(stage: Usd.Stage) -> None:
    """Add a shader of a renderer, which OpenUSD does not know."""
    shader = UsdShade.Shader.Define(stage, f"{MATERIAL}/arnold")
    shader.CreateIdAttr("arnold:standard_hair")
    shader.CreateInput("melanin", TYPES.Float).Set(0.9)


def instance(stage: Usd.Stage) -> None:
    """Add two instances of a cube with a material of its own."""
    made = Usd.Stage.CreateNew(str(Path(stage.GetRootLayer().realPath).with_name("prop.usda")))
    cube = UsdGeom.Cube.Define(made, "/prop/cube").GetPrim()
    surface = UsdShade.Shader.Define(made, "/prop/look/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    look = UsdShade.Material.Define(made, "/prop/look")
    look.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", TYPES.Token))
    UsdShade.MaterialBindingAPI.Apply(cube).Bind(look)
    made.Save()
    for name in ("left", "right"):
        prim = UsdGeom.Xform.Define(stage, f"/shot/{name}")
        prim.GetPrim().GetReferences().AddReference("./prop.usda", "/prop")
        prim.GetPrim().SetInstanceable(True)
        prim.AddTranslateOp().Set(Gf.Vec3d(1.0, 0.0, 0.0))


@pytest.mark.parametrize("change", [shade_elsewhere, instance])
def test_silent_on_good_heads(head: Usd.Stage, found: Callable, change: Plant) -> None:
    change(head)
    assert found(head) == []


def test_no_validator_waits_for_a_pipe(head: Usd.Stage) -> None:
    path = Path(head.GetRootLayer().realPath)
    for name in ("pipe.usda", "pipe.png"):
        os.mkfifo(path.with_name(name))
        attribute = head.GetPrimAtPath(HAIR).CreateAttribute(f"userProperties:{name[5:]}", TYPES.Asset)
        attribute.Set(Sdf.AssetPath(f"./{name}"))
    head.Save()
    assert [finding.rule for finding in lint(path)] == ["missing-file", "missing-file"]


def test_validators_run_on_one_thread_of_the_child(
    tmp_path: Path, written: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The library of linear algebra has threads of its own unless it is told not to."""
    code = """
import os
from hairpipe.formats.usd.check.lint import lint

def count_threads(path):
    assert lint(path) == []
    return len(os.listdir("/proc/self/task"))
"""
    (tmp_path / "counting_of_threads.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    module = importlib.import_module("counting_of_threads")
    assert work_apart(module.count_threads, written / "shot.usdc") == 1
