"""Rules for one program each: what Unreal, Houdini and Blender read of hair, and drop or misread without a message.

The rules are general; CLIENTS lists for each program what it reads, and UNSHOWN what no file can make a program show.
"""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from pxr import UsdGeom

from hairpipe.formats.usd.check.scene import TOKENS, Fault, Rule, Scene, Track, fault_of

TRIPLES = ("float3[]", "vector3f[]")
PAIRS = ("float2[]", "texCoord2f[]", "double2[]")
SCALARS = ("int[]", "float[]", "point3f[]", "string[]", *TRIPLES, *PAIRS)


class Primvar(NamedTuple):
    """A primvar that a program reads: its types, its interpolations, and whether hair needs it."""

    types: tuple[str, ...]
    interpolations: tuple[str, ...] = (TOKENS.uniform, TOKENS.constant)
    needed: bool = False


class Client(NamedTuple):
    """What a program reads of hair.

    schemas    API schemas without which curves are not hair
    primvars   those that it reads
    prefix     prefix of the primvars that it reads, of the types in `scalars`; empty: of all
    scalars    types that it reads
    widths     interpolations of widths that it reads
    bases      bases of cubic curves that it draws
    guides     whether strands marked as guides are not drawn
    relations  relationships of a binding that need a target
    """

    primvars: dict[str, Primvar]
    schemas: tuple[str, ...] = ()
    prefix: str = ""
    scalars: tuple[str, ...] = ()
    widths: tuple[str, ...] = (TOKENS.vertex, TOKENS.constant)
    bases: tuple[str, ...] = (TOKENS.catmullRom, TOKENS.bspline, TOKENS.bezier)
    guides: bool = False
    relations: tuple[str, ...] = ()


CLIENTS: dict[str, Client] = {
    "unreal": Client(
        {
            "groom_id": Primvar(("int[]", "float[]")),
            "groom_guide": Primvar(("int[]", "float[]")),
            "groom_group_id": Primvar(("int[]", "float[]")),
            "groom_group_name": Primvar(("string[]",)),
            "groom_root_uv": Primvar(PAIRS),
            "groom_closest_guides": Primvar((*TRIPLES, "int[]")),
            "groom_guide_weights": Primvar((*TRIPLES, "float[]")),
            "groom_color": Primvar(TRIPLES, (TOKENS.vertex, TOKENS.uniform)),
            "groom_roughness": Primvar(("float[]",), (TOKENS.vertex, TOKENS.uniform)),
            "groom_ao": Primvar(("float[]",), (TOKENS.vertex, TOKENS.uniform)),
        },
        schemas=("GroomAPI",),
        prefix="groom_",
        scalars=SCALARS,
        widths=(TOKENS.vertex, TOKENS.uniform),
        bases=(TOKENS.catmullRom,),
        guides=True,
        relations=("unreal:groomBinding:groom", "unreal:groomBinding:referenceMesh"),
    ),
    "houdini": Client({"rest": Primvar(("point3f[]", "float3[]", "vector3f[]"), (TOKENS.vertex,), needed=True)}),
    "blender": Client({}, bases=(TOKENS.catmullRom,)),
}


class Unshown(NamedTuple):
    """What a program does not show of the files of `export_usd`, and who says so.

    attribute  of hair, or a purpose of prims
    value      that it has then; empty: any
    message    what is not shown, and how to get it
    source     issue, page or file, or the release that we ran
    """

    program: str
    attribute: str
    value: str
    message: str
    source: str


KARMA = "https://www.sidefx.com/docs/houdini/nodes/lop/motionblur.html"
MOONRAY = "https://docs.openmoonray.org/user-reference/tools/hydra/hdmoonray-features"
UNREAL = "USDGroomConversion.cpp of Unreal 5"
UNSHOWN = (
    Unshown("blender", "material:binding", "", "no material on curves; `hairpipe blender FILE` binds one", "bpy 5.0.1"),
    Unshown("blender", "purpose", "guide", "not imported by default; enable Guide of the import", "bpy 5.0.1"),
    Unshown("blender", "purpose", "proxy", "not imported by default; enable Proxy of the import", "bpy 5.0.1"),
    Unshown("unreal", "velocities", "", "not read: a groom cache has positions, widths and colours", UNREAL),
    Unshown("unreal", "basis", "", "not read: points are joined as they are", UNREAL),
    Unshown("karma", "velocities", "", "no motion blur without Velocity Blur of a Motion Blur LOP", KARMA),
    Unshown("storm", "wrap", "pinned", "Catmull-Rom curves ended before root and tip in 23.05", "OpenUSD#2445"),
    Unshown("storm", "widths", "varying", "on pinned curves, replaced by 1; use vertex", "OpenUSD#2775"),
    Unshown("renderman", "widths", "varying", "refused as of a wrong size; use vertex", "OpenUSD#1308"),
    Unshown("moonray", "basis", "catmullRom", "not supported: linear, bspline and bezier are", MOONRAY),
    Unshown("moonray", "wrap", "pinned", "not supported", MOONRAY),
)
"""By program; Storm draws in usdview."""
PROGRAMS = tuple(dict.fromkeys((*CLIENTS, *(row.program for row in UNSHOWN))))


def unshown(name: str, scene: Scene) -> Iterator[Fault]:
    """Find what a program does not show, whatever the file states."""
    for row in (row for row in UNSHOWN if row.program == name):
        message = f"{f'is {row.value}: ' if row.value else ''}{row.message} (source: {row.source})"
        for prim in scene.stage.Traverse() if row.attribute == "purpose" and scene.hair else ():
            if prim.IsA(UsdGeom.Gprim) and UsdGeom.Imageable(prim).ComputePurpose() == row.value:
                yield fault_of(prim, message)
        for hair in scene.hair if row.attribute != "purpose" else ():
            if row.value in ("", _state_of(hair, row.attribute)) and hair.prim.HasProperty(row.attribute):
                yield hair.fault(row.attribute, message)


def _state_of(hair: Track, attribute: str) -> str:
    """Return the token of an attribute, or the interpolation of widths."""
    if attribute == "widths":
        return UsdGeom.Curves(hair.prim).GetWidthsInterpolation()
    return str(hair.prim.GetAttribute(attribute).Get())


def rules_for(name: str) -> tuple[Rule, ...]:
    """Return the rules for the scene of a stage that a program reads, one of PROGRAMS."""
    limits = Rule(f"{name}-unshown", "note", "scene", partial(unshown, name))
    client = CLIENTS.get(name)
    if client is None:
        return (limits,)
    found = {"schema": schemas, "primvar": primvars, "widths": widths, "basis": bases, "guides": guides}
    rules = [Rule(f"{name}-{key}", "error", "hair", partial(find, client, name)) for key, find in found.items()]
    return (*rules, Rule(f"{name}-binding", "error", "scene", partial(bindings, client)), limits)


def schemas(client: Client, name: str, _: Scene, hair: Track) -> Iterator[Fault]:
    """Find curves without the API schema by which a program knows hair."""
    above = hair.prim
    applied = set[str]()
    while above and not above.IsPseudoRoot():
        listed = above.GetMetadata("apiSchemas")  # a schema of another program is not registered here
        applied |= set(listed.GetAppliedItems() if listed else ())
        above = above.GetParent()
    for schema in client.schemas:
        if schema not in applied:
            yield fault_of(hair.prim, f"has no {schema}; {name} reads curves without it not as hair")


def primvars(client: Client, name: str, _: Scene, hair: Track) -> Iterator[Fault]:
    """Find primvars of a type, an interpolation or a number of values that a program ignores, and missing ones."""
    shape = hair.first
    given = {p.GetPrimvarName(): p for p in UsdGeom.PrimvarsAPI(hair.prim).GetPrimvarsWithValues()}
    for missing in (key for key, known in client.primvars.items() if known.needed and key not in given):
        yield hair.fault(f"primvars:{missing}", f"has no value; {name} needs it to deform hair by guides")
    for key, value in given.items():
        known = client.primvars.get(key)
        bare = key.removeprefix("primvars:")
        if known is None and client.prefix and f"{client.prefix}{bare}" in client.primvars:
            message = f"is not read, since its name does not begin with {client.prefix}"
            yield hair.fault(f"primvars:{key}", f"{message}; {name} reads {client.prefix}{bare}")
        if known is None and not (client.prefix and key.startswith(client.prefix)):
            continue
        kind = str(value.GetTypeName())
        types = client.scalars if known is None else known.types
        if kind not in types:
            yield hair.fault(f"primvars:{key}", f"is {kind}, which {name} ignores; it reads {', '.join(types)}")
        interpolation = value.GetInterpolation()
        if known is not None and interpolation not in known.interpolations:
            message = f"is {interpolation}, which {name} ignores; it reads {' or '.join(known.interpolations)}"
            yield hair.fault(f"primvars:{key}", message)
        count = len(value.ComputeFlattened(shape.time) or ())
        if shape.consistent and count != shape.size(interpolation):
            message = f"has {count} values, which {name} skips; {interpolation} takes {shape.size(interpolation)}"
            yield hair.fault(f"primvars:{key}", message)


def widths(client: Client, name: str, _: Scene, hair: Track) -> Iterator[Fault]:
    """Find widths with an interpolation that a program does not read."""
    curves = UsdGeom.Curves(hair.prim)
    interpolation = curves.GetWidthsInterpolation()
    if not curves.GetWidthsAttr().HasValue():
        yield hair.fault("widths", f"has no value; {name} draws hair one centimetre or one unit thick")
    elif interpolation not in client.widths:
        message = f"interpolation is {interpolation}, which {name} ignores; hair is too thick"
        yield hair.fault("widths", f"{message}; use {' or '.join(client.widths)}")


def bases(client: Client, name: str, _: Scene, hair: Track) -> Iterator[Fault]:
    """Find curves that a program draws through their control points."""
    curves = UsdGeom.BasisCurves(hair.prim)
    basis = curves.GetBasisAttr().Get()
    if curves.GetTypeAttr().Get() == TOKENS.cubic and basis not in client.bases:
        message = f"is {basis}, whose control points {name} draws as points of the curve"
        yield hair.fault("basis", f"{message}; use {' or '.join(client.bases)}")


def guides(client: Client, name: str, _: Scene, hair: Track) -> Iterator[Fault]:
    """Find hair all of whose strands are guides, which are not drawn, and guides that are named and do not exist."""
    api = UsdGeom.PrimvarsAPI(hair.prim)
    marks, closest = (api.GetPrimvar(key) for key in ("groom_guide", "groom_closest_guides"))
    values = np.asarray(marks.ComputeFlattened(hair.first.time)) if marks.HasValue() else np.zeros(0)
    if client.guides and len(values) and values.dtype.kind in "iuf" and (values != 0).all():
        yield hair.fault("primvars:groom_guide", f"marks all strands as guides, of which {name} draws none")
    ids = api.GetPrimvar("groom_id")
    if client.guides and closest.HasValue() and ids.HasValue():
        named = np.asarray(closest.ComputeFlattened(hair.first.time)).ravel()
        known = np.asarray(ids.ComputeFlattened(hair.first.time))
        if len(values) == len(known):
            known = known[values != 0]
        if not np.isin(np.rint(named), known).all():
            lost = np.rint(named)[~np.isin(np.rint(named), known)][0]
            message = f"names the guide {lost:g}, which is not the groom_id of a guide"
            yield hair.fault("primvars:groom_closest_guides", message)


def bindings(client: Client, scene: Scene) -> Iterator[Fault]:
    """Find bindings of hair to a skin without a target."""
    for prim in scene.stage.Traverse():
        if not any(prim.GetRelationship(name) for name in client.relations):
            continue
        for name in client.relations:
            targets = prim.GetRelationship(name).GetTargets() if prim.GetRelationship(name) else []
            if not any(scene.stage.GetPrimAtPath(path) for path in targets):
                yield Fault(f"{prim.GetPath()}.{name}", "has no target that exists; hair is not bound")
