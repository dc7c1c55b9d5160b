"""Rules for prims: tokens, relationships, kinds, fields; OpenUSD has no validators for these."""

from collections.abc import Iterator

from pxr import Kind, Sdf, Usd, UsdGeom, UsdVol

from hairpipe.formats.usd.check.finding import Fault, Rule


def token(prim: Usd.Prim) -> Iterator[Fault]:
    """Find tokens that are unknown to the schema; the fallback depends on the client."""
    for attribute in prim.GetAuthoredAttributes():
        declared = prim.GetPrimDefinition().GetSchemaAttributeSpec(attribute.GetName())
        allowed = list(declared.allowedTokens or ()) if isinstance(declared, Sdf.AttributeSpec) else []
        value = attribute.Get(Usd.TimeCode.EarliestTime()) if allowed else None
        if isinstance(value, str) and value not in allowed:
            yield Fault(str(attribute.GetPath()), f"is {value!r}; it has to be one of {', '.join(allowed)}")


def dangling_target(prim: Usd.Prim) -> Iterator[Fault]:
    """Find relationships and connections with missing targets."""
    for source in [*prim.GetAuthoredRelationships(), *prim.GetAuthoredAttributes()]:
        for target in missing_targets(source):
            yield Fault(str(source.GetPath()), f"leads to {target}, which does not exist")


def missing_targets(source: Usd.Property) -> list[Sdf.Path]:
    """Return the targets of a relationship, or connections of an attribute, that do not exist."""
    targets = source.GetTargets() if isinstance(source, Usd.Relationship) else source.GetConnections()
    return [target for target in targets if not source.GetStage().GetObjectAtPath(target)]


def target_outside(prim: Usd.Prim) -> Iterator[Fault]:
    """Find relationships to targets outside of the default prim: references to the file lose them."""
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
    """Find a proxy of the wrong purpose, which is drawn in addition to its original."""
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
    elif name == Kind.Tokens.component:
        above = [prim.GetStage().GetPrimAtPath(path) for path in prim.GetPath().GetPrefixes()[:-1]]
        if name in [Usd.ModelAPI(parent).GetKind() for parent in above]:
            yield Fault(str(prim.GetPath()), "is a component in a component; use subcomponent")


def volume_fields(prim: Usd.Prim) -> Iterator[Fault]:
    """Find volumes without a field, or with a field relationship to another prim."""
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


RULES = (
    Rule("token", "error", token),
    Rule("dangling-target", "error", dangling_target),
    Rule("target-outside", "warning", target_outside),
    Rule("proxy-target", "warning", proxy_target),
    Rule("kind", "warning", kind),
    Rule("volume-fields", "error", volume_fields),
)
