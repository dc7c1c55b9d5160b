"""Rules for composition: arcs that fail; variants, units, axes and rates of layers, which OpenUSD does not validate."""

import math
from collections.abc import Iterator

from pxr import Pcp, Sdf, Usd, UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.stage import shortened

UNIT, UP, CODES = "metersPerUnit", "upAxis", "timeCodesPerSecond"
MENDED = ("scale", "transform", "rotate", "orient")
"""Prefixes of the names of xformOps that convert the units or axes of an asset."""


def composition(stage: Usd.Stage) -> Iterator[Fault]:
    """Find broken arcs; CompositionErrorTest of OpenUSD does not distinguish them from missing files."""
    for error in stage.GetCompositionErrors():
        if not isinstance(error, (Pcp.ErrorInvalidAssetPath, Pcp.ErrorInvalidSublayerPath)):  # files have a rule
            path = getattr(error, "rootSite", None)
            yield Fault(str(path.path) if path else "/", shortened(str(error)))


def variants(prim: Usd.Prim) -> Iterator[Fault]:
    """Find selections of a missing variant."""
    for name in prim.GetVariantSets().GetNames():
        chosen = prim.GetVariantSet(name).GetVariantSelection()
        there = prim.GetVariantSet(name).GetVariantNames()
        if chosen and chosen not in there:
            message = f"the variant {chosen!r} of {name} is not there; there are {', '.join(there) or 'none'}"
            yield Fault(str(prim.GetPath()), message)


def layer_units(stage: Usd.Stage) -> Iterator[Fault]:
    """Find layers of another unit, up axis or rate, which USD does not convert."""
    unit = UsdGeom.GetStageMetersPerUnit(stage)
    up = UsdGeom.GetStageUpAxis(stage)
    rate = stage.GetTimeCodesPerSecond()
    mended = _mended_layers(stage)
    for layer in stage.GetUsedLayers(includeClipLayers=False):
        if layer.anonymous or layer == stage.GetRootLayer():
            continue
        facts = layer.pseudoRoot.GetInfo
        name = layer.GetDisplayName()
        free = layer in mended
        own = facts(UNIT) if layer.pseudoRoot.HasInfo(UNIT) else None
        if not free and own is not None and not math.isclose(own, unit, rel_tol=1e-6):
            yield Fault("/", f"{name} has {UNIT} {own:g}, the stage {unit:g}; nothing converts one into the other")
        if not free and layer.pseudoRoot.HasInfo(UP) and facts(UP) != up:
            yield Fault("/", f"{name} has {UP} {facts(UP)}, the stage {up}; nothing turns one into the other")
        if layer.HasTimeCodesPerSecond() and layer.timeCodesPerSecond != rate:
            message = f"{name} has {CODES} {layer.timeCodesPerSecond:g}, the stage {rate:g}; frames do not meet"
            yield Fault("/", message)


def _mended_layers(stage: Usd.Stage) -> set[Sdf.Layer]:
    """Return the layers under a scaled or rotated prim, as assets of other units have it."""
    found: set[Sdf.Layer] = set()
    for prim in stage.TraverseAll():
        ops = [n for n in prim.GetAuthoredPropertyNames() if n.startswith("xformOp:")]
        if any(name.split(":")[1].startswith(MENDED) for name in ops):
            found |= {spec.layer for spec in prim.GetPrimStack()}
    return found


RULES = (
    Rule("composition", "error", composition),
    Rule("layer-units", "error", layer_units),
)
PRIM_RULES = (Rule("variant", "error", variants),)
