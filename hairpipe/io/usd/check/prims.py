"""Rules for every prim, whatever it is: types, tokens, relationships, materials, skinning."""

from collections.abc import Iterator

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade, UsdSkel, UsdVol

from hairpipe.io.usd.check.finding import Fault, Rule

SKINNING = ("skel:", "primvars:skel:")


def nested_gprim(prim: Usd.Prim) -> Iterator[Fault]:
    """Find geometry under geometry, which renderers may skip."""
    above = prim.GetParent()
    if prim.IsA(UsdGeom.Gprim) and _within(above, UsdGeom.Gprim):
        yield Fault(str(prim.GetPath()), f"a {prim.GetTypeName()} stands under another shape; put them side by side")


def attribute_type(prim: Usd.Prim) -> Iterator[Fault]:
    """Find attributes that were authored with another type than the schema gives them."""
    for attribute in prim.GetAuthoredAttributes():
        declared = prim.GetPrimDefinition().GetSchemaAttributeSpec(attribute.GetName())
        for spec in attribute.GetPropertyStack():
            if declared and spec.typeName != declared.typeName:
                yield Fault(str(attribute.GetPath()), f"is of type {spec.typeName}; it has to be {declared.typeName}")


def token(prim: Usd.Prim) -> Iterator[Fault]:
    """Find tokens that the schema does not know; clients fall back to something else, each to its own."""
    for attribute in prim.GetAuthoredAttributes():
        declared = prim.GetPrimDefinition().GetSchemaAttributeSpec(attribute.GetName())
        allowed = list(declared.allowedTokens or ()) if isinstance(declared, Sdf.AttributeSpec) else []
        value = attribute.Get(Usd.TimeCode.EarliestTime()) if allowed else None
        if isinstance(value, str) and value not in allowed:
            yield Fault(str(attribute.GetPath()), f"is {value!r}; it has to be one of {', '.join(allowed)}")


def dangling_target(prim: Usd.Prim) -> Iterator[Fault]:
    """Find relationships and connections that lead nowhere."""
    for source in [*prim.GetAuthoredRelationships(), *prim.GetAuthoredAttributes()]:
        targets = source.GetTargets() if isinstance(source, Usd.Relationship) else source.GetConnections()
        for target in targets:
            if not prim.GetStage().GetObjectAtPath(target):
                yield Fault(str(source.GetPath()), f"leads to {target}, which does not exist")


def volume_fields(prim: Usd.Prim) -> Iterator[Fault]:
    """Find volumes without a field, or whose field relationship leads to something else."""
    if not prim.IsA(UsdVol.Volume):
        return
    fields = UsdVol.Volume(prim).GetFieldPaths()
    if not fields:
        yield Fault(str(prim.GetPath()), "the volume has no field relationship")
    for name, path in fields.items():
        target = prim.GetStage().GetPrimAtPath(path)
        if target and not target.IsA(UsdVol.FieldBase):
            yield Fault(
                f"{prim.GetPath()}.field:{name}", f"leads to {path}, which is a {target.GetTypeName()}, no field"
            )


def material_binding(prim: Usd.Prim) -> Iterator[Fault]:
    """Find bindings that are ignored since the API is not applied, or that lead to something other than a material."""
    bindings = [r for r in prim.GetAuthoredRelationships() if r.GetName().split(":")[:2] == ["material", "binding"]]
    if bindings and not prim.HasAPI(UsdShade.MaterialBindingAPI):
        yield Fault(str(prim.GetPath()), "binds a material without the MaterialBindingAPI")
    for binding in bindings:
        for path in binding.GetTargets():
            target = prim.GetStage().GetPrimAtPath(path)
            if target and not target.IsA(UsdShade.Material) and "collection" not in binding.GetName():
                yield Fault(str(binding.GetPath()), f"leads to {path}, a {target.GetTypeName()} and no Material")


def shader_id(prim: Usd.Prim) -> Iterator[Fault]:
    """Find shaders that do not say which one they are."""
    shader = UsdShade.Shader(prim)
    if shader and shader.GetImplementationSource() == UsdShade.Tokens.id and not shader.GetShaderId():
        yield Fault(str(prim.GetPath()), "the shader has no info:id")


def skin_binding(prim: Usd.Prim) -> Iterator[Fault]:
    """Find skinning that is ignored: without the SkelBindingAPI, or not under a SkelRoot."""
    if prim.IsA(UsdSkel.Skeleton) or prim.IsA(UsdSkel.Root):
        return
    skinned = any(p.GetName().startswith(SKINNING) for p in prim.GetAuthoredProperties())
    if skinned and not prim.HasAPI(UsdSkel.BindingAPI):
        yield Fault(str(prim.GetPath()), "has skinning attributes without the SkelBindingAPI")
    elif skinned and not _within(prim, UsdSkel.Root):
        yield Fault(str(prim.GetPath()), "is skinned, but stands under no SkelRoot")


def transform(prim: Usd.Prim) -> Iterator[Fault]:
    """Find prims that are nowhere."""
    if prim.IsA(UsdGeom.Xformable):
        world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.EarliestTime())
        if not np.isfinite(np.array(world)).all():
            yield Fault(str(prim.GetPath()), "the transform to the world is not finite")


def _within(prim: Usd.Prim, schema: type) -> bool:
    while prim and not prim.IsA(schema):
        prim = prim.GetParent()
    return bool(prim)


RULES = (
    Rule("nested-gprim", "error", nested_gprim),
    Rule("attribute-type", "error", attribute_type),
    Rule("token", "error", token),
    Rule("dangling-target", "error", dangling_target),
    Rule("volume-fields", "error", volume_fields),
    Rule("material-binding", "error", material_binding),
    Rule("shader-id", "error", shader_id),
    Rule("skin-binding", "error", skin_binding),
    Rule("transform", "error", transform),
)
