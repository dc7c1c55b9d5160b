"""Defects of a few strands among many, of level sets that stand still, of holes, and of hair that nothing selects."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdVol

from hairpipe.formats.usd.check.lint import lint

HAIR, BODY, STRANDS = "/shot/hair", "/shot/body", 30
Edit = Callable[[np.ndarray], np.ndarray]


def edit(path: str, name: str, change: Edit, *times: float) -> Callable[[Usd.Stage], None]:
    """Plant another value of an attribute, at all times unless some are given."""

    def plant(stage: Usd.Stage) -> None:
        attribute = stage.GetAttributeAtPath(f"{path}.{name}")
        for time in times or attribute.GetTimeSamples() or [None]:
            at = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
            old = attribute.Get(at)
            new = change(np.array(old))
            attribute.Set(type(old).FromNumpy(np.ascontiguousarray(new, np.array(old).dtype)), at)

    return plant


def strands(change: Edit, *times: float, names: tuple[str, ...] = ("points", "velocities")) -> Callable:
    """Plant other points and velocities, given as (strands, points, 3), and the box that goes with them."""

    def plant(stage: Usd.Stage) -> None:
        for name in names:
            edit(HAIR, name, lambda p: change(p.reshape(STRANDS, -1, 3)).reshape(-1, 3), *times)(stage)
        prim = UsdGeom.BasisCurves(stage.GetPrimAtPath(HAIR))
        for time in prim.GetPointsAttr().GetTimeSamples():
            points = prim.GetPointsAttr().Get(time)
            prim.GetExtentAttr().Set(UsdGeom.Curves.ComputeExtent(points, prim.GetWidthsAttr().Get()), time)

    return plant


def of(strand: int, change: Edit) -> Edit:
    """Change one strand."""

    def changed(values: np.ndarray) -> np.ndarray:
        values = values.copy()
        values[strand] = change(values[strand])
        return values

    return changed


def swapped(values: np.ndarray) -> np.ndarray:
    order = np.arange(len(values))
    order[[3, 7]] = [7, 3]
    return values[order]


def level_set(stage: Usd.Stage, *files: str) -> None:
    """Plant a level set, of one file for all frames, or of a file a frame."""
    volume = UsdVol.Volume.Define(stage, "/shot/levelset")
    field = UsdVol.OpenVDBAsset.Define(stage, "/shot/levelset/surface")
    volume.CreateFieldRelationship("surface", field.GetPath())
    for file in files:
        Path(stage.GetRootLayer().realPath).with_name(file).write_bytes(b"vdb" * 1000)
    for time, file in zip(range(1001, 1009), files, strict=False):
        field.CreateFilePathAttr().Set(Sdf.AssetPath(f"./{file}"), time)


def without_faces(stage: Usd.Stage) -> None:
    """Plant a skin without every fourth of its lower faces, on which no hair stands."""
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(BODY))
    corners = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    roots = stage.GetAttributeAtPath(f"{HAIR}.primvars:skinprim")
    kept = np.arange(len(corners)) % 4 > 0
    kept[np.array(roots.Get())] = True
    roots.Set((np.cumsum(kept) - 1)[np.array(roots.Get())].tolist())
    mesh.GetFaceVertexCountsAttr().Set([3] * int(kept.sum()))
    mesh.GetFaceVertexIndicesAttr().Set(corners[kept].ravel().tolist())
    edit(BODY, "primvars:st", lambda st: st.reshape(-1, 3, 2)[kept].reshape(-1, 2))(stage)


def in_variant(stage: Usd.Stage) -> None:
    """Plant hair in a variant that nothing selects."""
    layer = stage.GetRootLayer()
    stage.GetPrimAtPath("/shot").GetVariantSets().AddVariantSet("groom").AddVariant("long")
    variant = layer.GetPrimAtPath("/shot").variantSets["groom"].variants["long"].primSpec
    Sdf.CopySpec(layer, HAIR, layer, variant.path.AppendChild("hair"))
    stage.RemovePrim(HAIR)


DEFECTS: dict[str, tuple[Callable[[Usd.Stage], object], str]] = {
    "one reversed": (strands(of(4, lambda s: s[::-1])), "roots"),
    "two swapped": (strands(swapped), "roots"),
    "one elsewhere for a frame": (strands(of(4, lambda s: s + 0.5), 1004, names=("points",)), "roots strand-jumps"),
    "a third without velocities": (
        edit(HAIR, "velocities", lambda v: v * (np.arange(len(v)) // 6 % 3 > 0)[:, None]),
        "velocity-match",
    ),
    "a third without velocities for a frame": (
        edit(HAIR, "velocities", lambda v: v * (np.arange(len(v)) // 6 % 3 > 0)[:, None], 1004),
        "velocity-match",
    ),
    "one backwards": (strands(of(4, lambda s: -s), names=("velocities",)), "velocity-match"),
    "one tip far away": (strands(of(4, lambda s: s + np.eye(6)[5][:, None]), names=("points",)), "stretch spike"),
    "no rest": (lambda s: s.GetPrimAtPath(HAIR).RemoveProperty("primvars:pref"), "rest"),
    "rest of others": (edit(HAIR, "primvars:pref", lambda p: np.roll(p, 6 * 11, axis=0)), "rest"),
    "rest mirrored": (edit(HAIR, "primvars:pref", lambda p: p * [-1, 1, 1]), "rest"),
    "one thick": (edit(HAIR, "widths", lambda w: np.where(np.arange(len(w)) < 6, 50 * w, w)), "widths-uneven extent"),
    "gaps": (edit(HAIR, "widths", lambda w: w * (np.arange(len(w)) % 6 != 2)), "widths-uneven"),
    "declared holes": (lambda s: UsdGeom.Mesh(s.GetPrimAtPath(BODY)).CreateHoleIndicesAttr([0, 5, 10]), "holes"),
    "missing faces": (without_faces, "holes"),
    "one level set": (lambda s: level_set(s, "a.vdb"), "volume-still"),
    "one content": (lambda s: level_set(s, *(f"a.{n}.vdb" for n in range(1001, 1009))), "volume-still"),
    "normals all upward": (edit(BODY, "normals", lambda n: 0 * n + [0, 1, 0]), "normals"),
    "a frame twice": (
        lambda s: [
            s.GetAttributeAtPath(f"{path}.{name}").Set(s.GetAttributeAtPath(f"{path}.{name}").Get(1004), 1005)
            for path in (HAIR, BODY)
            for name in ("points", "velocities", "extent")
        ],
        "velocity-match",
    ),
    "unselected": (in_variant, "hair-drawn"),
}


@pytest.mark.parametrize(("plant", "rules"), DEFECTS.values(), ids=DEFECTS)
def test_names_the_defect(head: Usd.Stage, found: Callable, plant: Callable, rules: str) -> None:
    plant(head)
    seen = {rule for rule, _ in found(head)}
    assert set(rules.split()) <= seen, seen


def test_silent_on_widths_that_end_at_0_and_on_hair_in_a_selected_variant(head: Usd.Stage, found: Callable) -> None:
    edit(HAIR, "widths", lambda w: w * (np.arange(len(w)) % 6 != 5))(head)
    in_variant(head)
    head.GetPrimAtPath("/shot").GetVariantSet("groom").SetVariantSelection("long")
    assert "hair-drawn" not in {rule for rule, _ in found(head)} and "widths-uneven" not in {r for r, _ in found(head)}


def test_a_missing_box_is_a_warning(head: Usd.Stage) -> None:
    head.GetPrimAtPath(HAIR).RemoveProperty("extent")
    head.Save()
    findings = lint(Path(head.GetRootLayer().realPath))
    assert [(f.rule, f.severity) for f in findings] == [("extent", "warning")]


@pytest.mark.parametrize("rate", [24.0, 30.0])
def test_a_clip_of_another_rate_is_found_though_nothing_has_opened_it(
    clips: Usd.Stage, found: Callable, rate: float
) -> None:
    path = Path(clips.GetRootLayer().realPath).parent / "shot.clips" / "shot.1005.usdc"
    clip = Sdf.Layer.OpenAsAnonymous(str(path))
    clip.timeCodesPerSecond = clip.framesPerSecond = rate
    clip.Export(str(path))
    Sdf.Layer.FindOrOpen(str(path)).Reload(True)
    assert found(clips) == [("clip-rates", "/shot")] * (rate != 24.0)
