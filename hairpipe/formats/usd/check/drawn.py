"""Rules for visibility: hair in the file that is not drawn."""

from collections.abc import Iterator

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import OURS, Scene, Snapshot
from hairpipe.formats.usd.stage import RENDERED

CURVES = "BasisCurves"
SAME = 0.5  # share of strands at the same place from which two grooms are equal
NEAR = 1e-4  # distance of equal places, over the size of the shape


def hair_drawn(stage: Usd.Stage) -> Iterator[Fault]:
    """Find hair that is not drawn: invisible, inactive, without a definition, of another purpose."""
    whole = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)
    hair = [prim for prim in Usd.PrimRange(stage.GetPseudoRoot(), whole) if _holds_hair(prim)]
    why = {prim: why_hidden(prim, UsdGeom.BasisCurves) for prim in hair}
    bare = all(why.values())
    for prim, (message, time, meant) in ((prim, reason) for prim, reason in why.items() if reason):
        if bare or not meant:
            yield Fault(str(prim.GetPath()), f"{message}; none of this hair is drawn", time)


def hair_selected(stage: Usd.Stage) -> Iterator[Fault]:
    """Find hair in a variant that is not selected, where the selected one has none."""
    drawn = any(prim.IsA(UsdGeom.BasisCurves) for prim in stage.Traverse(Usd.TraverseInstanceProxies()))
    for prim in stage.TraverseAll():
        for name in prim.GetVariantSets().GetNames():
            chosen = prim.GetVariantSet(name).GetVariantSelection()
            sets = [spec.variantSets[name] for spec in prim.GetPrimStack() if name in spec.variantSets]
            hairy = {v.name for s in sets for v in s.variants.values() if _curves_under(v.primSpec)}
            if hairy and chosen not in hairy and (not chosen or not drawn):
                what = f"selects {chosen!r}" if chosen else "selects nothing"
                yield Fault(str(prim.GetPath()), f"{what} of {name}, but the hair is in {', '.join(sorted(hairy))}")


def _holds_hair(prim: Usd.Prim) -> bool:
    if prim.IsActive() and prim.IsLoaded():
        if prim.IsA(UsdGeom.BasisCurves) or not prim.HasAttribute("curveVertexCounts"):
            return prim.IsA(UsdGeom.BasisCurves)
        named = any(prim.GetAttribute(name).HasAuthoredValue() for name in (*OURS, "basis", "wrap"))
        return named or not prim.IsA(UsdGeom.Curves)
    return any(_curves_under(spec) for spec in prim.GetPrimStack())


def _curves_under(spec: Sdf.PrimSpec) -> bool:
    return spec.typeName == CURVES or any(_curves_under(child) for child in spec.nameChildren)


def why_hidden(prim: Usd.Prim, kind: type[UsdGeom.Gprim]) -> tuple[str, float | None, bool] | None:
    """Return why a prim is not drawn, since when, and whether this may be intended where others are drawn."""
    purpose = UsdGeom.Imageable(prim).ComputePurpose() if UsdGeom.Imageable(prim) else UsdGeom.Tokens.default_
    reasons = {
        "is inactive": not prim.IsActive(),
        "is a class, or stands under one, which is there to be inherited": prim.IsAbstract(),
        "is an over, or stands under one, which nothing defines": not prim.IsDefined(),
        f"has the type {prim.GetTypeName() or 'none'}, not {kind.__name__}": not prim.IsA(kind),
        f"has the purpose {purpose}, not {' or '.join(RENDERED)}": purpose not in RENDERED,
    }
    first = next((message for message, holds in reasons.items() if holds), None)
    if first:
        return first, None, prim.IsActive() and (prim.IsAbstract() or purpose not in RENDERED)
    since = _invisible_since(prim)
    return None if since is None else ("is invisible", since.GetValue() if since.IsNumeric() else None, False)


def _invisible_since(prim: Usd.Prim) -> Usd.TimeCode | None:
    times = {Usd.TimeCode.EarliestTime()}
    above = prim
    while above.IsA(UsdGeom.Imageable):
        times |= {Usd.TimeCode(t) for t in UsdGeom.Imageable(above).GetVisibilityAttr().GetTimeSamples()}
        above = above.GetParent()
    seen = ((t, UsdGeom.Imageable(prim).ComputeVisibility(t)) for t in sorted(times, key=lambda t: t.GetValue()))
    found = next((t for t, visibility in seen if visibility == UsdGeom.Tokens.invisible), None)
    return Usd.TimeCode.Default() if found == Usd.TimeCode.EarliestTime() else found


def hair_in_default(scene: Scene) -> Iterator[Fault]:
    """Find a default prim without hair: references to the file have none."""
    default = scene.stage.GetDefaultPrim()
    paths = [track.prim.GetPath() for track in scene.hair]
    if default and paths and not any(path.HasPrefix(default.GetPath()) for path in paths):
        message = f"is the defaultPrim, but the hair is {paths[0]}; who refers to this file gets none"
        yield Fault(str(default.GetPath()), message)


def instanced(scene: Scene) -> Iterator[Fault]:
    """Find hair that is an instance: all of them share one motion."""
    for track in scene.hair:
        if track.moves and track.prim.IsInstanceProxy():
            yield Fault(str(track.prim.GetPath()), "is simulated, but an instance; set instanceable to false")
    moving = [track.prim.GetPath() for track in scene.hair if track.moves]
    for prim in scene.stage.Traverse():
        prototypes = UsdGeom.PointInstancer(prim).GetPrototypesRel().GetTargets() if _scatters(prim) else []
        for path in (hair for hair in moving if any(hair.HasPrefix(above) for above in prototypes)):
            yield Fault(str(path), f"is simulated, but scattered by {prim.GetPath()}; all instances move alike")


def _scatters(prim: Usd.Prim) -> bool:
    return prim.IsA(UsdGeom.PointInstancer)


def doubled(scene: Scene) -> Iterator[Fault]:
    """Find strands and meshes that are drawn twice at one place."""
    for shapes in (scene.hair, scene.meshes):
        marks = [_marks(track.first) for track in shapes]
        for i, mark in enumerate(marks):
            if len(np.unique(mark, axis=0)) < (1 - NEAR) * len(mark) and shapes is scene.hair:
                message = f"{len(mark) - len(np.unique(mark, axis=0))} strands coincide with others"
                yield Fault(shapes[i].path("points"), message, shapes[i].first.code)
            twin = next((j for j in range(i) if _share(mark, marks[j]) > SAME), None)
            if twin is not None:
                message = f"coincides with {shapes[twin].prim.GetPath()}; the hair is drawn twice"
                yield Fault(str(shapes[i].prim.GetPath()), message, shapes[i].first.code)


def _marks(shape: Snapshot) -> np.ndarray:
    """Return places that distinguish strands, or vertices, as multiples of the tolerance."""
    if not (shape.sound or not shape.curves) or not len(shape.points):
        return np.empty((0, 9), np.int64)
    size = max(np.linalg.norm(np.ptp(shape.placed, axis=0)), np.finfo(np.float64).tiny)
    unit = NEAR * 2.0 ** np.ceil(np.log2(size))  # the same for two grooms of nearly one size
    places = np.nan_to_num(np.rint(shape.placed / unit)).astype(np.int64)
    if not shape.curves:
        return places
    middles = (shape.roots + shape.tips + 1) // 2
    marks = np.concatenate([places[shape.roots], places[middles], places[shape.tips]], axis=1)
    guides = shape.array("primvars:groom_guide")  # a guide may lie on the hair of which it is a copy
    return marks if guides is None or len(guides) != len(marks) or guides.all() else marks[guides == 0]


def _share(these: np.ndarray, those: np.ndarray) -> float:
    if not (len(these) and len(those)) or these.shape[1] != those.shape[1]:
        return 0.0
    both = np.concatenate([np.unique(these, axis=0), np.unique(those, axis=0)])
    shared = len(both) - len(np.unique(both, axis=0))
    return shared / min(len(these), len(those))


STAGE_RULES = (Rule("hair-drawn", "error", hair_drawn), Rule("hair-drawn", "error", hair_selected))
RULES = (
    Rule("default-prim", "error", hair_in_default),
    Rule("instanced-hair", "warning", instanced),
    Rule("doubled", "error", doubled),
)
