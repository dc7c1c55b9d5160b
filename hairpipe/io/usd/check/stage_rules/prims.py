"""Rules for every prim, whatever it is: types, tokens, relationships, skinning."""

from collections.abc import Iterator

from pxr import Kind, Sdf, Usd, UsdGeom, UsdSkel, UsdVol

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


def target_outside(prim: Usd.Prim) -> Iterator[Fault]:
    """Find relationships that leave the default prim: they are lost where somebody refers to the file."""
    default = prim.GetStage().GetDefaultPrim()
    root = default.GetPath() if default else Sdf.Path.emptyPath
    if not default or not prim.GetPath().HasPrefix(root) or prim.IsInstanceProxy():
        return
    for relationship in prim.GetAuthoredRelationships():
        for target in relationship.GetTargets():
            if not target.HasPrefix(root) and prim.GetStage().GetObjectAtPath(target):
                message = f"leads to {target}, outside of {root}; who refers to this file loses it"
                yield Fault(str(relationship.GetPath()), message)


def proxy_target(prim: Usd.Prim) -> Iterator[Fault]:
    """Find a stand-in of the wrong purpose, which is drawn in addition to its original."""
    relationship = prim.GetRelationship("proxyPrim")
    for path in relationship.GetTargets() if relationship else ():
        proxy = UsdGeom.Imageable(prim.GetStage().GetPrimAtPath(path))
        if proxy and proxy.ComputePurpose() != UsdGeom.Tokens.proxy:
            yield Fault(str(relationship.GetPath()), f"leads to {path} of purpose {proxy.ComputePurpose()}; use proxy")


def kind(prim: Usd.Prim) -> Iterator[Fault]:
    """Find unknown kinds, and components in a component."""
    name = Usd.ModelAPI(prim).GetKind()
    if name and not Kind.Registry.HasKind(name):
        known = ", ".join(sorted(Kind.Registry.GetAllKinds()))
        yield Fault(str(prim.GetPath()), f"the kind {name!r} is unknown; there are {known}")
    elif name == Kind.Tokens.component and any(_is_component(above) for above in _above(prim)):
        yield Fault(str(prim.GetPath()), "is a component in a component; use subcomponent")


def _is_component(prim: Usd.Prim) -> bool:
    return Usd.ModelAPI(prim).GetKind() == Kind.Tokens.component


def _above(prim: Usd.Prim) -> Iterator[Usd.Prim]:
    while prim := prim.GetParent():
        yield prim


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
                f"{prim.GetPath()}.field:{name}", f"leads to {path}, which is a {target.GetTypeName()}, not a field"
            )


def skin_binding(prim: Usd.Prim) -> Iterator[Fault]:
    """Find skinning that is ignored: without the SkelBindingAPI, or not under a SkelRoot."""
    if prim.IsA(UsdSkel.Skeleton) or prim.IsA(UsdSkel.Root):
        return
    skinned = any(p.GetName().startswith(SKINNING) for p in prim.GetAuthoredProperties())
    if skinned and not prim.HasAPI(UsdSkel.BindingAPI):
        yield Fault(str(prim.GetPath()), "has skinning attributes without the SkelBindingAPI")
    elif skinned and not _within(prim, UsdSkel.Root):
        yield Fault(str(prim.GetPath()), "is skinned, but is not under a SkelRoot")


def _within(prim: Usd.Prim, schema: type) -> bool:
    while prim and not prim.IsA(schema):
        prim = prim.GetParent()
    return bool(prim)


RULES = (
    Rule("nested-gprim", "error", nested_gprim),
    Rule("attribute-type", "error", attribute_type),
    Rule("token", "error", token),
    Rule("dangling-target", "error", dangling_target),
    Rule("target-outside", "warning", target_outside),
    Rule("proxy-target", "warning", proxy_target),
    Rule("kind", "warning", kind),
    Rule("volume-fields", "error", volume_fields),
    Rule("skin-binding", "error", skin_binding),
)
