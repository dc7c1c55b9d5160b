"""Rules for materials: a known surface, valid inputs, opaque hair."""

from collections.abc import Iterator

import numpy as np
from pxr import Sdr, Usd, UsdShade

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import Scene

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
        yield Fault(str(prim.GetPath()), "the shader has no info:id")
    elif not Sdr.Registry().GetShaderNodeByIdentifier(name) and not name.startswith(FAMILIES):
        yield Fault(str(prim.GetPath()), f"the shader {name!r} is unknown to clients; use {OWN}")


def surface(prim: Usd.Prim) -> Iterator[Fault]:
    """Find materials without a surface: their shapes are grey or black."""
    if prim.IsA(UsdShade.Material):
        outputs = [out for out in UsdShade.Material(prim).GetOutputs() if out.GetBaseName() in ("surface", "volume")]
        if not any(out.GetAttr().HasAuthoredConnections() for out in outputs):
            yield Fault(str(prim.GetPath()), "the material has no surface that is connected to a shader")
        for out in outputs:
            for path in out.GetAttr().GetConnections():
                source = prim.GetStage().GetAttributeAtPath(path)
                if source and not UsdShade.Output.IsOutput(source):
                    yield Fault(str(out.GetAttr().GetPath()), f"leads to {path}, which is not an output of a shader")


def shader_inputs(prim: Usd.Prim) -> Iterator[Fault]:
    """Find unknown inputs of a surface, and values out of range; OpenUSD validates types only."""
    shader = UsdShade.Shader(prim)
    if not shader or shader.GetShaderId() != OWN:
        return
    node = Sdr.Registry().GetShaderNodeByIdentifier(OWN)
    known = node.GetShaderInputNames()
    for given in shader.GetInputs():
        name = given.GetBaseName()
        value = None if given.HasConnectedSource() else given.Get()
        if name not in known:
            yield Fault(str(given.GetAttr().GetPath()), f"is not an input of {OWN}, which has {', '.join(known)}")
        elif name in BETWEEN and np.asarray(value).dtype.kind in "iuf":
            least, most = BETWEEN[name]
            if not ((np.asarray(value) >= least) & (np.asarray(value) <= most)).all():
                yield Fault(str(given.GetAttr().GetPath()), f"is {value}; {least} to {most} is possible")
            elif name == "opacity" and value == 0:
                yield Fault(str(given.GetAttr().GetPath()), "is 0, so that nothing is seen")


def hair_looks(scene: Scene) -> Iterator[Fault]:
    """Find transparent hair, and hair without a material where others have one."""
    for track in scene.hair:
        opacity = track.first.array("primvars:displayOpacity")
        if opacity is not None and len(opacity) and not opacity.any():
            yield Fault(track.path("primvars:displayOpacity"), "is 0, so that nothing is seen")
    shapes = [*scene.hair, *scene.meshes]
    bound = [bool(UsdShade.MaterialBindingAPI(t.prim).ComputeBoundMaterial()[0]) for t in shapes]
    tried = [t.prim.HasRelationship("material:binding") for t in shapes]
    material = any(prim.IsA(UsdShade.Material) for prim in scene.stage.Traverse())
    for track, has, tries in zip(scene.hair, bound, tried, strict=False):
        if material and not has and not tries:
            some = track.prim.GetAuthoredPropertiesInNamespace("material:binding")
            message = f"{some[0].GetName()} alone leaves out previews" if some else "the stage has some"
            yield Fault(str(track.prim.GetPath()), f"is not bound to a material for all purposes; {message}")


PRIM_RULES = (
    Rule("shader-id", "error", shader_id),
    Rule("surface", "error", surface),
    Rule("shader-input", "error", shader_inputs),
)
RULES = (Rule("hair-material", "warning", hair_looks),)
