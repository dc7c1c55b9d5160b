"""Rules for a stage: unit, rate, time range, composition, hair that is not drawn, files that it names, value clips.

We have a rule of our own where OpenUSD has no validator, or where the docstring names its limitation. The validators
of UsdUtils are not run: they open every file that a stage names, and never return from a pipe.
"""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Ar, Pcp, Sdf, Tf, Usd, UsdGeom, UsdValidation, UsdVol

from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.scene import OURS, TINY, Fault, Finding, Scene, Snapshot, fault_of
from hairpipe.formats.usd.stage import RENDERED, clip_names, message_of, shortened, specs_in
from hairpipe.plain_file import special


def metres_per_unit(stage: Usd.Stage) -> Iterator[Fault]:
    """Find a unit that is not a positive length; the validator of OpenUSD finds only a missing one."""
    scale = UsdGeom.GetStageMetersPerUnit(stage)
    if not (math.isfinite(scale) and scale > 0):
        yield Fault("/", f"metersPerUnit is {scale:g}; it has to be positive")


def frame_rate(stage: Usd.Stage) -> Iterator[Fault]:
    """Find a stage with undefined velocities, or with another playback rate than its frames."""
    codes = stage.GetTimeCodesPerSecond()
    frames = stage.GetFramesPerSecond()
    if not (math.isfinite(codes) and codes > 0):
        yield Fault("/", f"timeCodesPerSecond is {codes:g}; it has to be positive")
    elif not stage.HasAuthoredMetadata("timeCodesPerSecond"):
        if is_animated(stage):
            yield Fault("/", "no timeCodesPerSecond")
    elif not math.isclose(codes, frames, rel_tol=1e-6):
        yield Fault("/", f"timeCodesPerSecond is {codes:g} and framesPerSecond {frames:g}; they have to be equal")


def time_codes(stage: Usd.Stage) -> Iterator[Fault]:
    """Find a stage without a time range."""
    if not stage.HasAuthoredTimeCodeRange():
        if is_animated(stage):
            yield Fault("/", "no startTimeCode and endTimeCode")
    elif not has_range(stage):
        yield Fault("/", f"startTimeCode {stage.GetStartTimeCode():g} is after endTimeCode {stage.GetEndTimeCode():g}")


def has_range(stage: Usd.Stage) -> bool:
    """Return whether the stage has a valid time range."""
    start = stage.GetStartTimeCode()
    end = stage.GetEndTimeCode()
    return stage.HasAuthoredTimeCodeRange() and math.isfinite(end - start) and start <= end


def is_animated(stage: Usd.Stage) -> bool:
    prims = stage.Traverse(Usd.TraverseInstanceProxies())
    return any(a.ValueMightBeTimeVarying() for prim in prims for a in prim.GetAttributes())


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
            others = ", ".join(there) or "none"
            yield fault_of(prim, f"the variant {chosen!r} of {name} is not there; there are {others}")


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
            yield Fault("/", f"{name} has {CODES} {layer.timeCodesPerSecond:g}, the stage {rate:g}; frames do not meet")


def _mended_layers(stage: Usd.Stage) -> set[Sdf.Layer]:
    """Return the layers under a scaled or rotated prim, as assets of other units have it."""
    found: set[Sdf.Layer] = set()
    for prim in stage.TraverseAll():
        ops = [n for n in prim.GetAuthoredPropertyNames() if n.startswith("xformOp:")]
        if any(name.split(":")[1].startswith(MENDED) for name in ops):
            found |= {spec.layer for spec in prim.GetPrimStack()}
    return found


KEYWORDS = ["UsdCoreValidators", "UsdGeomValidators", "UsdShadeValidators", "UsdSkelValidators"]
DESCRIBED = {"CompositionError", "MissingShaderIdInRegistry"}
"""Errors that rules of ours describe better: `composition`, `prim_rules.shader_id`."""
RULE_OF_ERROR = {
    "AttributeTypeMismatch": "attribute-type",
    "InvalidMaterialCollection": "material-binding",
    "InvalidNestedGprims": "nested-gprim",
    "InvalidResourcePath": "material-binding",
    "InvalidSkelBindingAPIApply": "skin-binding",
    "MaterialBindingPropNotARel": "material-binding",
    "MismatchedPropertyType": "shader-input",
    "MissingDefaultPrim": "default-prim",
    "MissingMaterialBindingAPI": "material-binding",
    "MissingMetersPerUnitMetadata": "metres-per-unit",
    "MissingSkelBindingAPI": "skin-binding",
    "MissingUpAxisMetadata": "up-axis",
}
"""Names of findings by the name of the error; of any other error, its identifier is the name."""
MESSAGES = {
    "default-prim": "no defaultPrim that exists",
    "metres-per-unit": "no metersPerUnit",
    "nested-gprim": "is under another shape, and renderers may skip it; put the two side by side",
    "up-axis": "no upAxis",
}
"""Messages where the text of OpenUSD repeats the path of the file, or does not state the remedy."""


def validate(stage: Usd.Stage) -> Iterator[Finding]:
    """Run the validators on a stage, and yield their errors as findings, ordered by name and path."""
    registry = UsdValidation.ValidationRegistry()
    names = [validator.name for validator in registry.GetValidatorMetadataForKeywords(KEYWORDS)]
    errors = UsdValidation.ValidationContext(registry.GetOrLoadValidatorsByName(names)).Validate(stage)
    findings = list[Finding]()
    for error in errors:
        properties = [site.GetProperty() for site in error.GetSites() if site.IsProperty()]
        # Missing targets of properties are reported by `prim_rules.dangling_target`.
        if error.GetName() not in DESCRIBED and not any(map(missing_targets, properties)):
            findings.append(_finding(error))
    yield from sorted(findings, key=lambda f: (f.rule, f.path, f.message))  # threads report in any order


def _finding(error: UsdValidation.ValidationError) -> Finding:
    rule = RULE_OF_ERROR.get(error.GetName(), str(error.GetIdentifier()))
    site = error.GetSites()[0]
    if site.IsValidSpecInLayer():
        path = (site.GetPropertySpec() or site.GetPrimSpec()).path
    else:
        path = (site.GetProperty() if site.IsProperty() else site.GetPrim()).GetPath()
    message = MESSAGES.get(rule) or shortened(error.GetMessage())
    broken = error.GetType() == UsdValidation.ValidationErrorType.Error
    return Finding(rule, str(path), None, message, "error" if broken else "warning")


def missing_targets(source: Usd.Property) -> list[Sdf.Path]:
    """Return the targets of a relationship, or connections of an attribute, that do not exist."""
    targets = source.GetTargets() if isinstance(source, Usd.Relationship) else source.GetConnections()
    return [target for target in targets if not source.GetStage().GetObjectAtPath(target)]


SAME = 0.5  # share of strands at the same place from which two grooms are equal
NEAR = 1e-4  # distance of equal places, over the size of the shape


DEFORMED = "primvars:guideIndex"
"""Attribute of strands that readers deform by guides and activate; see docs/howto/guides.md."""


def hair_drawn(stage: Usd.Stage) -> Iterator[Fault]:
    """Find hair that is not drawn: invisible, inactive, without a definition, of another purpose."""
    whole = Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)
    prims = Usd.PrimRange(stage.GetPseudoRoot(), whole)
    hair = [prim for prim in prims if _holds_hair(prim) and not prim.HasAttribute(DEFORMED)]
    why = {prim: why_hidden(prim, UsdGeom.BasisCurves) for prim in hair}
    bare = all(why.values())
    for prim, (message, time, meant) in ((prim, reason) for prim, reason in why.items() if reason):
        if bare or not meant:
            yield fault_of(prim, f"{message}; none of this hair is drawn", time)


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
                yield fault_of(prim, f"{what} of {name}, but the hair is in {', '.join(sorted(hairy))}")


def _holds_hair(prim: Usd.Prim) -> bool:
    if prim.IsActive() and prim.IsLoaded():
        if prim.IsA(UsdGeom.BasisCurves) or not prim.HasAttribute("curveVertexCounts"):
            return prim.IsA(UsdGeom.BasisCurves)
        named = any(prim.GetAttribute(name).HasAuthoredValue() for name in (*OURS, "basis", "wrap"))
        return named or not prim.IsA(UsdGeom.Curves)
    return any(_curves_under(spec) for spec in prim.GetPrimStack())


def _curves_under(spec: Sdf.PrimSpec) -> bool:
    return spec.typeName == "BasisCurves" or any(_curves_under(child) for child in spec.nameChildren)


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
        yield fault_of(default, f"is the defaultPrim, but the hair is {paths[0]}; who refers to this file gets none")


def instanced(scene: Scene) -> Iterator[Fault]:
    """Find hair that is an instance: all of them share one motion."""
    for track in scene.hair:
        if track.moves and track.prim.IsInstanceProxy():
            yield fault_of(track.prim, "is simulated, but an instance; set instanceable to false")
    moving = [track.prim.GetPath() for track in scene.hair if track.moves]
    for prim in filter(lambda prim: prim.IsA(UsdGeom.PointInstancer), scene.stage.Traverse()):
        prototypes = UsdGeom.PointInstancer(prim).GetPrototypesRel().GetTargets()
        for path in (hair for hair in moving if any(hair.HasPrefix(above) for above in prototypes)):
            yield Fault(str(path), f"is simulated, but scattered by {prim.GetPath()}; all instances move alike")


def doubled(scene: Scene) -> Iterator[Fault]:
    """Find strands and meshes that are drawn twice at one place."""
    for shapes in (scene.hair, scene.meshes):
        marks = [_marks(track.first) for track in shapes]
        for i, mark in enumerate(marks):
            if len(np.unique(mark, axis=0)) < (1 - NEAR) * len(mark) and shapes is scene.hair:
                message = f"{len(mark) - len(np.unique(mark, axis=0))} strands coincide with others"
                yield shapes[i].fault("points", message, shapes[i].first.code)
            twin = next((j for j in range(i) if _share(mark, marks[j]) > SAME), None)
            if twin is not None:
                message = f"coincides with {shapes[twin].prim.GetPath()}; the hair is drawn twice"
                yield fault_of(shapes[i].prim, message, shapes[i].first.code)


def _marks(shape: Snapshot) -> np.ndarray:
    """Return places that distinguish strands, or vertices, as multiples of the tolerance."""
    if not (shape.sound or not shape.curves) or not len(shape.points):
        return np.empty((0, 9), np.int64)
    size = max(np.linalg.norm(np.ptp(shape.placed, axis=0)), TINY)
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


ABSOLUTE = re.compile(r"^(/|\\\\|[A-Za-z]:[/\\]|file:)")
CLASSES = {"levelSet": "level set", "fogVolume": "fog volume", "staggered": "staggered"}
"""Names of grid classes in USD, and in OpenVDB."""


@dataclass(frozen=True)
class Asset:
    """A file that a layer names.

    layer  layer that names the file
    path   of the prim or attribute
    name   as in the layer
    time   code of the sample, or None
    data   whether the file contains frames, which belong to the layer, and is not a shared asset
    """

    layer: Sdf.Layer
    path: str
    name: str
    time: float | None = None
    data: bool = False

    @property
    def file(self) -> str:
        """Return the path of the file, empty for a missing one."""
        return Ar.GetResolver().Resolve(self.layer.ComputeAbsolutePath(self.name)).GetPathString()


def find_assets(stage: Usd.Stage) -> list[Asset]:
    """Return every file that the layers of a stage name, also missing ones."""
    return [asset for layer in stage.GetUsedLayers() if not layer.anonymous for asset in _named_by(layer)]


def _named_by(layer: Sdf.Layer) -> Iterator[Asset]:
    yield from (Asset(layer, "/", name) for name in layer.subLayerPaths)
    for spec in specs_in(layer):
        path = str(spec.path)
        if isinstance(spec, Sdf.PrimSpec):
            arcs = (arc for list_ in (spec.referenceList, spec.payloadList) for arc in list_.GetAddedOrExplicitItems())
            yield from (Asset(layer, path, arc.assetPath) for arc in arcs if arc.assetPath)
            yield from (Asset(layer, path, name, data=True) for name in clip_names(spec))
        elif isinstance(spec, Sdf.AttributeSpec) and spec.typeName.scalarType == Sdf.ValueTypeNames.Asset:
            yield from _values(layer, spec)


def _values(layer: Sdf.Layer, spec: Sdf.AttributeSpec) -> Iterator[Asset]:
    times = layer.ListTimeSamplesForPath(spec.path)
    values = [(None, spec.default), *((time, layer.QueryTimeSample(spec.path, time)) for time in times)]
    for time, value in values:
        for asset in value if isinstance(value, Sdf.AssetPathArray) else [value]:
            if isinstance(asset, Sdf.AssetPath) and asset.path and "<UDIM>" not in asset.path:
                yield Asset(layer, str(spec.path), asset.path, time, data=time is not None)


def missing_file(asset: Asset) -> Iterator[Fault]:
    """Find missing files; MissingReferenceValidator of OpenUSD names no attribute or time, and hangs at a pipe."""
    if not asset.file:
        yield Fault(asset.path, f"names {asset.name}, which does not exist", asset.time)
    elif kind := special(Path(asset.file.partition("[")[0])):
        yield Fault(asset.path, f"names {asset.name}, which is {kind}", asset.time)


def broken_layer(asset: Asset) -> Iterator[Fault]:
    """Find existing layers that cannot be opened."""
    plain = asset.file and not special(Path(asset.file.partition("[")[0]))
    if plain and Sdf.FileFormat.FindByExtension(asset.file):
        try:
            Sdf.Layer.FindOrOpen(asset.file)
        except Tf.ErrorException as error:
            yield Fault(asset.path, f"names {asset.name}, which does not open: {message_of(error)}", asset.time)


def absolute_path(asset: Asset) -> Iterator[Fault]:
    """Find files that do not exist on another machine."""
    if ABSOLUTE.match(asset.name):
        yield Fault(asset.path, f"names {asset.name}; use a path relative to the layer", asset.time)
    elif "\\" in asset.name:
        yield Fault(asset.path, f"names {asset.name}, found on one system alone; write / between folders", asset.time)
    elif asset.data and asset.name.startswith("../"):
        yield Fault(asset.path, f"names {asset.name}, which is not in the folder of the layer or below", asset.time)


Inspect = Callable[[Path], Sequence[Any]]
"""Lists the grids of an OpenVDB file, with `name` and `grid_class`; raises BadInput for another file."""


def openvdb_grid(prim: Usd.Prim, inspect: Inspect | None) -> Iterator[Fault]:
    """Find OpenVDB files that cannot be opened, or do not have the grid of the field's name and class."""
    if inspect is None or not prim.IsA(UsdVol.OpenVDBAsset):
        return
    field = UsdVol.OpenVDBAsset(prim)
    attribute = field.GetFilePathAttr()
    for time in attribute.GetTimeSamples() or [None]:
        asset = attribute.Get(Usd.TimeCode.Default() if time is None else time)
        if asset and asset.resolvedPath:
            message = _mismatch(Path(asset.resolvedPath), field, inspect)
            if message:
                yield fault_of(attribute, message, time)


def _mismatch(path: Path, field: UsdVol.OpenVDBAsset, inspect: Inspect) -> str:
    try:
        grids = {grid.name: grid.grid_class for grid in inspect(path)}
    except BadInput as fault:
        return f"{path.name} does not open: {fault.what}"
    name = field.GetFieldNameAttr().Get()
    kind = field.GetFieldClassAttr().Get()
    if name not in grids:
        return f"{path.name} has no grid {name!r}, but {', '.join(map(repr, sorted(grids))) or 'none at all'}"
    if kind in CLASSES and grids[name] != CLASSES[kind]:
        return f"grid {name!r} of {path.name} is a {grids[name] or 'grid without class'}, no {CLASSES[kind]}"
    return ""


METRICS = ("timeCodesPerSecond", "framesPerSecond", "metersPerUnit", "upAxis")
"""Metadata of layers that clips do not convert."""


Clips = list[tuple[str, Sdf.Layer | None]]


def _clip_sets(prim: Usd.Prim) -> Iterator[tuple[str, str, Sdf.Layer | None, Clips]]:
    """Yield the sets of value clips: name, path of the prim in the clips, manifest, and files with their layers."""
    api = Usd.ClipsAPI(prim)
    for name in prim.GetMetadata("clips") or {}:
        clips = [(asset.path, _open(prim, asset)) for asset in api.ComputeClipAssetPaths(name)]
        yield name, api.GetClipPrimPath(name), _open(prim, api.GetClipManifestAssetPath(name)), clips


def _open(prim: Usd.Prim, asset: Sdf.AssetPath | None) -> Sdf.Layer | None:
    if not asset or not asset.path:
        return None
    resolved = asset.resolvedPath or prim.GetStage().GetRootLayer().ComputeAbsolutePath(asset.path)
    return Sdf.Layer.FindOrOpen(resolved)


def clip_manifest(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without a manifest: all of them are opened for the first value."""
    for name, clips in (prim.GetMetadata("clips") or {}).items():
        if not clips.get("manifestAssetPath"):
            yield fault_of(prim, f"clip set {name} has no manifestAssetPath")


def clip_values(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without an attribute of the manifest; USD interpolates it from their neighbours."""
    for _, path, manifest, clips in _clip_sets(prim):
        promised = _attributes(manifest, path or "/") if manifest else []
        for file, clip in clips:
            lacking = [p for p in promised if not clip.ListTimeSamplesForPath(p)] if clip else []
            if lacking:
                yield fault_of(prim, f"{file} has no samples of {lacking[0]}; {len(lacking)} such")


def clip_undeclared(prim: Usd.Prim) -> Iterator[Fault]:
    """Find attributes of clips that the manifest does not declare: they are never read."""
    for name, path, manifest, clips in _clip_sets(prim):
        if manifest is None:
            continue
        if not path or not manifest.GetPrimAtPath(path):
            yield fault_of(prim, f"clip set {name} has the primPath {path!r}, which its manifest has not")
            continue
        for file, clip in clips:
            held = [p for p in _attributes(clip, path) if clip.ListTimeSamplesForPath(p)] if clip else []
            lacking = [p for p in held if not manifest.GetAttributeAtPath(p)]
            if lacking:
                yield Fault(str(lacking[0]), f"{file} has samples, but the manifest does not declare it")


def clip_times(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips without a sample at a time at which they are played."""
    api = Usd.ClipsAPI(prim)
    for name, path, _, clips in _clip_sets(prim):
        if api.GetClipTemplateAssetPath(name) or not path:
            continue
        active = [(time, int(index)) for time, index in api.GetClipActive(name) or []]
        unknown = [index for _, index in active if not 0 <= index < len(clips)]
        idle = sorted(set(range(len(clips))) - {index for _, index in active})
        if unknown or idle:
            what = f"activates clip {unknown[0]}" if unknown else f"never activates {clips[idle[0]][0]}"
            yield fault_of(prim, f"clip set {name} {what}; there are {len(clips)} clips")
        times = dict(api.GetClipTimes(name) or [])
        wrong = []
        for time, (file, clip) in ((time, clips[index]) for time, index in active if 0 <= index < len(clips)):
            own = clip.ListAllTimeSamples() if clip else []
            wrong += [(time, file)] if own and times.get(time, time) not in own else []
        if wrong:
            time, file = wrong[0]
            message = f"{file} has no sample at {times.get(time, time):g}, when it is played; {len(wrong)} such"
            yield fault_of(prim, message, time)


def clip_rates(prim: Usd.Prim) -> Iterator[Fault]:
    """Find clips of another rate, unit or up axis than the stage, which USD does not convert."""
    root = prim.GetStage().GetRootLayer().pseudoRoot
    for *_, clips in _clip_sets(prim):
        unlike: dict[str, list[str]] = {}
        for file, clip in ((file, clip) for file, clip in clips if clip):
            for field in METRICS:
                own = clip.pseudoRoot.GetInfo(field) if clip.pseudoRoot.HasInfo(field) else None
                if own is not None and root.HasInfo(field) and own != root.GetInfo(field):
                    unlike.setdefault(f"{field} {own}, the stage {root.GetInfo(field)}", []).append(file)
        for what, files in unlike.items():
            yield fault_of(prim, f"{files[0]} has {what}; {len(files)} such clips")


def _attributes(layer: Sdf.Layer, root: str) -> list[Sdf.Path]:
    paths: list[Sdf.Path] = []
    layer.Traverse(Sdf.Path(root), paths.append)
    specs = [layer.GetAttributeAtPath(path) for path in paths if path.IsPropertyPath()]
    return [spec.path for spec in specs if spec and spec.variability == Sdf.VariabilityVarying]
