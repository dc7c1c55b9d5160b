"""Rules for prims, where OpenUSD has no validators: tokens, targets, kinds, materials, transforms, samples in time."""

import re
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from pxr import Kind, Sdf, Sdr, Usd, UsdGeom, UsdShade, UsdVol

from hairpipe.formats.usd.check.scene import Fault, Scene, Track, fault_of
from hairpipe.formats.usd.check.stage_rules import has_range, missing_targets


def token(prim: Usd.Prim) -> Iterator[Fault]:
    """Find tokens that are unknown to the schema; the fallback depends on the client."""
    for attribute in prim.GetAuthoredAttributes():
        declared = prim.GetPrimDefinition().GetSchemaAttributeSpec(attribute.GetName())
        allowed = list(declared.allowedTokens or ()) if isinstance(declared, Sdf.AttributeSpec) else []
        value = attribute.Get(Usd.TimeCode.EarliestTime()) if allowed else None
        if isinstance(value, str) and value not in allowed:
            yield fault_of(attribute, f"is {value!r}; it has to be one of {', '.join(allowed)}")


def dangling_target(prim: Usd.Prim) -> Iterator[Fault]:
    """Find relationships and connections with missing targets."""
    for source in [*prim.GetAuthoredRelationships(), *prim.GetAuthoredAttributes()]:
        for target in missing_targets(source):
            yield fault_of(source, f"leads to {target}, which does not exist")


def target_outside(prim: Usd.Prim) -> Iterator[Fault]:
    """Find relationships to targets outside of the default prim: references to the file lose them."""
    default = prim.GetStage().GetDefaultPrim()
    root = default.GetPath() if default else Sdf.Path.emptyPath
    if not default or not prim.GetPath().HasPrefix(root) or prim.IsInstanceProxy():
        return
    for relationship in prim.GetAuthoredRelationships():
        for target in relationship.GetTargets():
            if not target.HasPrefix(root) and prim.GetStage().GetObjectAtPath(target):
                yield fault_of(relationship, f"leads to {target}, outside of {root}; who refers to this file loses it")


def proxy_target(prim: Usd.Prim) -> Iterator[Fault]:
    """Find a proxy of the wrong purpose, which is drawn in addition to its original."""
    relationship = prim.GetRelationship("proxyPrim")
    for path in relationship.GetTargets() if relationship else ():
        proxy = UsdGeom.Imageable(prim.GetStage().GetPrimAtPath(path))
        if proxy and proxy.ComputePurpose() != UsdGeom.Tokens.proxy:
            yield fault_of(relationship, f"leads to {path} of purpose {proxy.ComputePurpose()}; use proxy")


def kind(prim: Usd.Prim) -> Iterator[Fault]:
    """Find unknown kinds, and components in a component."""
    name = Usd.ModelAPI(prim).GetKind()
    if name and not Kind.Registry.HasKind(name):
        known = ", ".join(sorted(Kind.Registry.GetAllKinds()))
        yield fault_of(prim, f"the kind {name!r} is unknown; there are {known}")
    elif name == Kind.Tokens.component:
        above = [prim.GetStage().GetPrimAtPath(path) for path in prim.GetPath().GetPrefixes()[:-1]]
        if name in [Usd.ModelAPI(parent).GetKind() for parent in above]:
            yield fault_of(prim, "is a component in a component; use subcomponent")


def volume_fields(prim: Usd.Prim) -> Iterator[Fault]:
    """Find volumes without a field, or with a field relationship to another prim."""
    if not prim.IsA(UsdVol.Volume):
        return
    fields = UsdVol.Volume(prim).GetFieldPaths()
    if not fields:
        yield fault_of(prim, "the volume has no field relationship")
    for name, path in fields.items():
        target = prim.GetStage().GetPrimAtPath(path)
        if target and not target.IsA(UsdVol.FieldBase):
            message = f"leads to {path}, which is a {target.GetTypeName()}, not a field"
            yield Fault(f"{prim.GetPath()}.field:{name}", message)


OWN = "UsdPreviewSurface"
FAMILIES = ("ND_", "arnold:", "Pxr", "karma", "kma_", "vray:", "VRay", "redshift", "RS", "octane:", "mtlx", "OmniPBR")
"""Prefixes of the names of shaders of renderers, which OpenUSD does not ship."""
BETWEEN = {"roughness": (0, 1), "metallic": (0, 1), "opacity": (0, 1), "clearcoat": (0, 1), "ior": (0.1, 10)}
BETWEEN |= {"diffuseColor": (0, 1), "specularColor": (0, 1)}
"""Ranges of the inputs of UsdPreviewSurface."""


def shader_id(prim: Usd.Prim) -> Iterator[Fault]:
    """Find shaders without an id or with an unknown one; ShaderSdrCompliance of OpenUSD rejects those of renderers."""
    shader = UsdShade.Shader(prim)
    if not shader or shader.GetImplementationSource() != UsdShade.Tokens.id:
        return
    name = shader.GetShaderId()
    if not name:
        yield fault_of(prim, "the shader has no info:id")
    elif not Sdr.Registry().GetShaderNodeByIdentifier(name) and not name.startswith(FAMILIES):
        yield fault_of(prim, f"the shader {name!r} is unknown to clients; use {OWN}")


def surface(prim: Usd.Prim) -> Iterator[Fault]:
    """Find materials without a surface: their shapes are grey or black."""
    if prim.IsA(UsdShade.Material):
        outputs = [out for out in UsdShade.Material(prim).GetOutputs() if out.GetBaseName() in ("surface", "volume")]
        if not any(out.GetAttr().HasAuthoredConnections() for out in outputs):
            yield fault_of(prim, "the material has no surface that is connected to a shader")
        for out in outputs:
            for path in out.GetAttr().GetConnections():
                source = prim.GetStage().GetAttributeAtPath(path)
                if source and not UsdShade.Output.IsOutput(source):
                    yield fault_of(out.GetAttr(), f"leads to {path}, which is not an output of a shader")


def shader_inputs(prim: Usd.Prim) -> Iterator[Fault]:
    """Find unknown inputs of a surface, and values out of range; OpenUSD validates types only."""
    shader = UsdShade.Shader(prim)
    if not shader or shader.GetShaderId() != OWN:
        return
    known = Sdr.Registry().GetShaderNodeByIdentifier(OWN).GetShaderInputNames()
    for given in shader.GetInputs():
        name = given.GetBaseName()
        value = None if given.HasConnectedSource() else given.Get()
        if name not in known:
            yield fault_of(given.GetAttr(), f"is not an input of {OWN}, which has {', '.join(known)}")
        elif name in BETWEEN and np.asarray(value).dtype.kind in "iuf":
            least, most = BETWEEN[name]
            if not ((np.asarray(value) >= least) & (np.asarray(value) <= most)).all():
                yield fault_of(given.GetAttr(), f"is {value}; {least} to {most} is possible")
            elif name == "opacity" and value == 0:
                yield fault_of(given.GetAttr(), "is 0, so that nothing is seen")


def hair_looks(scene: Scene) -> Iterator[Fault]:
    """Find transparent hair, and hair without a material where others have one."""
    for track in scene.hair:
        opacity = track.first.array("primvars:displayOpacity")
        if opacity is not None and len(opacity) and not opacity.any():
            yield track.fault("primvars:displayOpacity", "is 0, so that nothing is seen")
    material = any(prim.IsA(UsdShade.Material) for prim in scene.stage.Traverse())
    for track in scene.hair if material else ():
        bound = UsdShade.MaterialBindingAPI(track.prim).ComputeBoundMaterial()[0]
        if not bound and not track.prim.HasRelationship("material:binding"):
            some = track.prim.GetAuthoredPropertiesInNamespace("material:binding")
            message = f"{some[0].GetName()} alone leaves out previews" if some else "the stage has some"
            yield fault_of(track.prim, f"is not bound to a material for all purposes; {message}")


PREFIX, ORDER = "xformOp:", "xformOpOrder"
RESET, INVERT = "!resetXformStack!", "!invert!"
EQUAL = 1e-3  # tolerance of equal scales
FLAT = 1e-9  # volume over the cube of the size from which a transform is singular


def transform(prim: Usd.Prim) -> Iterator[Fault]:
    """Find transforms that are not finite, or singular."""
    ops = [a for a in prim.GetAuthoredAttributes() if a.GetName().startswith(PREFIX)]
    times = sorted({time for attribute in ops for time in attribute.GetTimeSamples()}) or [None]
    for code in times if prim.IsA(UsdGeom.Xformable) else ():
        time = Usd.TimeCode.EarliestTime() if code is None else Usd.TimeCode(code)
        world = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time))
        axes = world[:3, :3]
        if not np.isfinite(world).all():
            yield fault_of(prim, "the transform to the world is not finite", code)
            return
        if abs(np.linalg.det(axes)) <= FLAT * np.abs(axes).max() ** 3:
            yield fault_of(prim, "the transform to the world has no volume; all is flat", code)
            return


def ignored_transform(prim: Usd.Prim) -> Iterator[Fault]:
    """Find ops of a transform that xformOpOrder omits, or names without an attribute."""
    order = list(prim.GetAttribute(ORDER).Get() or []) if prim.HasAttribute(ORDER) else []
    named = {name.removeprefix(INVERT) for name in order if name != RESET}
    there = {a.GetName() for a in prim.GetAuthoredAttributes() if a.GetName().startswith(PREFIX) and a.HasValue()}
    for name in sorted(there - named):
        yield Fault(f"{prim.GetPath()}.{name}", f"is ignored; {ORDER} has to name it")
    for name in sorted(named - there):
        yield Fault(f"{prim.GetPath()}.{ORDER}", f"names {name}, which has no value")


def reset_transform(prim: Usd.Prim) -> Iterator[Fault]:
    """Find prims that do not move with their parent."""
    xform = UsdGeom.Xformable(prim)
    parent = UsdGeom.Xformable(prim.GetParent())
    if xform and parent and xform.GetResetXformStack():
        yield fault_of(prim, f"resets its transform, so that it does not go with {parent.GetPath()}")


def hair_transform(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find hair that is mirrored, sheared, or of another scale than the body or its own widths."""
    path = str(track.prim.GetPath())
    axes = track.first.world[:3, :3]
    own = np.array(UsdGeom.Xformable(track.prim).GetLocalTransformation(track.first.time))[:3, :3]
    scales = np.linalg.svd(axes, compute_uv=False)
    bound = track.has("primvars:skinprim")
    bodies = [_scale(mesh.first.world[:3, :3]) for mesh in scene.meshes if scene.moves(mesh) or bound]
    if not np.isfinite(axes).all() or not scales.all():
        return
    if np.linalg.det(axes) < 0:
        yield Fault(path, "is mirrored by its transform; mirror the points, and keep the transform a movement")
    elif scales[0] > (1 + EQUAL) * scales[-1]:
        message = f"is scaled by {scales[0]:.3g} one way and by {scales[-1]:.3g} another"
        yield Fault(path, f"{message}; widths know one scale")
    elif bodies and all(abs(_scale(axes) / body - 1) > EQUAL for body in bodies):
        yield Fault(path, f"is scaled by {_scale(axes):.3g}, where the body is by {bodies[0]:.3g}")
    elif abs(_scale(own) - 1) > EQUAL and not bodies:
        yield Fault(path, f"is scaled by {_scale(own):.3g} of its own; scale the points, widths and velocities")


def _scale(axes: np.ndarray) -> float:
    return float(np.cbrt(abs(np.linalg.det(axes)))) or 1.0


FOLLOWERS = ("velocities", "accelerations", "normals", "extent")
TOPOLOGY = ("curveVertexCounts", "faceVertexCounts", "faceVertexIndices", "primvars:hairId")
LISTED = 8  # number of gaps in a message
NUMBER = re.compile(r"(\d+)\.\w+$")
NEAR = 2  # frames of a mistaken offset of files
CLOSE = 1e-2  # frames between samples of one rounded time


def sample_gaps(prim: Usd.Prim) -> Iterator[Fault]:
    """Find frames without a sample, which clients interpolate without a warning."""
    attribute = _leader(prim)
    stage = prim.GetStage()
    times = np.unique(attribute.GetTimeSamples())
    times = times[times == np.round(times)]  # others are for motion blur
    if len(times) < 2:
        return
    step = np.diff(times).min()
    start, end = (stage.GetStartTimeCode(), stage.GetEndTimeCode()) if has_range(stage) else times[[0, -1]]
    before = max(0, (times[0] - start) // step)
    after = max(0, (end - times[-1]) // step)
    gaps = np.concatenate([[before], np.round(np.diff(times) / step) - 1, [after]])
    firsts = np.concatenate([[times[0] - before * step], times + step])
    if gaps.any():
        pairs = zip(firsts, gaps, strict=True)
        listed = [f"{t:g} to {t + (n - 1) * step:g}" if n > 1 else f"{t:g}" for t, n in pairs if n]
        more = f" and {len(listed) - LISTED} more" if len(listed) > LISTED else ""
        message = f"has no sample at {', '.join(listed[:LISTED])}{more}; {gaps.sum():.0f} frames missing"
        yield fault_of(attribute, message, float(firsts[np.argmax(gaps > 0)]))


def sample_range(prim: Usd.Prim) -> Iterator[Fault]:
    """Find samples outside of the stage's time codes."""
    attribute = _leader(prim)
    stage = prim.GetStage()
    times = attribute.GetTimeSamples() if has_range(stage) else []
    outside = [t for t in times if not stage.GetStartTimeCode() <= t <= stage.GetEndTimeCode()]
    if outside:
        span = f"{stage.GetStartTimeCode():g} to {stage.GetEndTimeCode():g}"
        yield fault_of(attribute, f"{len(outside)} samples lie outside of {span}", outside[0])


def sample_times(prim: Usd.Prim) -> Iterator[Fault]:
    """Find split samples, and velocities, normals and extents with other sample times than the points."""
    points = prim.GetAttribute("points")
    times = points.GetTimeSamples() if points else []
    twice = [late for early, late in pairwise(times) if late - early < CLOSE]
    if twice:
        yield fault_of(points, f"has two samples within {CLOSE:g} of a frame; {len(twice)} such", twice[0])
    for name in FOLLOWERS if len(times) > 1 else ():
        follower = prim.GetAttribute(name)
        lacking = sorted(set(times) - set(follower.GetTimeSamples())) if follower and follower.HasValue() else []
        if lacking:
            message = f"has no sample at {len(lacking)} of {len(times)} times at which points has one"
            yield fault_of(follower, message, lacking[0])


def topology(prim: Usd.Prim) -> Iterator[Fault]:
    """Find strands, faces or ids that change in time: motion blur and value clips require constant ones."""
    for name in TOPOLOGY:
        attribute = prim.GetAttribute(name)
        times = attribute.GetTimeSamples() if attribute else []
        first = attribute.Get(times[0]) if len(times) > 1 else None
        changed = [time for time in times[1:] if attribute.Get(time) != first]
        if changed:
            yield fault_of(attribute, f"changes in time, at {len(changed)} samples", changed[0])


def frame_names(prim: Usd.Prim) -> Iterator[Fault]:
    """Find files of another frame than the one at which they are played, by the number in their name."""
    attribute = prim.GetAttribute("filePath")
    times = attribute.GetTimeSamples() if prim.IsA(UsdVol.OpenVDBAsset) else []
    names = {time: NUMBER.search(attribute.Get(time).path) for time in times if attribute.Get(time)}
    late = {time: int(found[1]) - time for time, found in names.items() if found}
    usual = np.median(list(late.values())) if late else 0.0
    wanted = 0.0 if abs(usual) <= NEAR else usual  # frames may be counted from 1
    wrong = [time for time, offset in late.items() if offset != wanted]
    if wrong:
        message = f"is frame {wrong[0] + late[wrong[0]]:g} by its name, not {wrong[0] + wanted:g}; {len(wrong)} such"
        yield fault_of(attribute, message, wrong[0])


def _leader(prim: Usd.Prim) -> Usd.Attribute:
    return prim.GetAttribute("filePath" if prim.IsA(UsdVol.OpenVDBAsset) else "points")
