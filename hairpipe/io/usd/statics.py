"""Constant values of a shot: strands, rest positions, root bindings, faces and materials."""

import numpy as np
from pxr import Gf, Sdf, UsdGeom, UsdShade, UsdUtils, Vt

from hairpipe.data import Groom, Mesh, Strands
from hairpipe.data.drawn_widths import DIAMETERS
from hairpipe.errors import BadInput
from hairpipe.io.usd.samples import integers, vectors

HAIR_COLOUR = Gf.Vec3f(0.09, 0.045, 0.013)
HAIR_ROUGHNESS = 0.4
"""Colour and roughness of brown hair in bulk.

Eumelanin 0.4 absorbs 0.4 (0.419, 0.697, 1.37) [d'Eon et al. 2011], which makes this the colour of a mass of hair,
exp(-5.89 sqrt(absorption)) [Chiang et al. 2016, azimuthal roughness 0.3].
"""
KERATIN = 1.55
"""Index of refraction."""
SKIN_COLOUR = Gf.Vec3f(0.6, 0.4, 0.33)
SKIN_ROUGHNESS = 0.6
FLESH = 1.4
TYPES, TOKENS = Sdf.ValueTypeNames, UsdGeom.Tokens
BASES = {"catmull_rom": TOKENS.catmullRom, "bspline": TOKENS.bspline}
"""Bases of the curves, by the name of the setting."""


def author_hair(
    prim: UsdGeom.BasisCurves,
    strands: Strands,
    diameters: np.ndarray | None,
    groom: Groom | None,
    simulated: np.ndarray | None,
    basis: str,
) -> None:
    """Author the strands, their width, ids and material, and from the groom their rest and roots.

    diameters  diameters at points where the widths of the strands are others, (p,) [m]: `hairDiameter`
    simulated  strands that are not interpolated, (S,) bool: `groom_guide`, the name in Unreal and Alembic grooms
    basis      basis of the curves, one of BASES

    Raises BadInput if the groom does not have these strands.
    """
    counts = np.diff(strands.offsets)
    author_curves(prim, counts, basis)
    prim.CreateWidthsAttr(Vt.FloatArray.FromNumpy(np.ascontiguousarray(strands.widths_at_points(), np.float32)))
    prim.SetWidthsInterpolation(TOKENS.vertex)
    if diameters is not None:
        values = Vt.FloatArray.FromNumpy(np.ascontiguousarray(diameters, np.float32))
        _primvar(prim, DIAMETERS, TYPES.FloatArray, TOKENS.vertex, values)
    if groom is None:
        _primvar(prim, "hairId", TYPES.IntArray, TOKENS.uniform, integers(np.arange(len(counts))))
    else:
        _author_groom(prim, strands, groom)
    if simulated is not None:
        _primvar(prim, "groom_guide", TYPES.IntArray, TOKENS.uniform, integers(simulated))


def author_curves(prim: UsdGeom.BasisCurves, counts: np.ndarray, basis: str) -> None:
    """Author pinned cubic curves of so many points each, (S,), with the material of hair."""
    prim.CreateTypeAttr(TOKENS.cubic)
    prim.CreateBasisAttr(basis)
    prim.CreateWrapAttr(TOKENS.pinned)
    prim.CreateCurveVertexCountsAttr(integers(counts))
    _bind(prim, "hair", HAIR_COLOUR, HAIR_ROUGHNESS, KERATIN)


def _author_groom(prim: UsdGeom.BasisCurves, strands: Strands, groom: Groom) -> None:
    if not np.array_equal(groom.offsets, strands.offsets):
        raise BadInput("the groom does not have the strands of the hair", where="groom", right="what was simulated")
    coordinates = UsdUtils.GetPrimaryUVSetName()
    pairs = Vt.Vec2fArray.FromNumpy
    in_triangle = np.ascontiguousarray(groom.root_barycentrics[:, 1:], np.float32)
    _primvar(prim, UsdUtils.GetPrefName(), TYPES.Point3fArray, TOKENS.vertex, vectors(groom.points))
    _primvar(prim, "hairId", TYPES.IntArray, TOKENS.uniform, integers(groom.ids))
    if groom.root_uv.any():  # a scalp without texture coordinates leaves 0
        _primvar(prim, coordinates, TYPES.TexCoord2fArray, TOKENS.uniform, pairs(np.float32(groom.root_uv)))
    _primvar(prim, "skinprim", TYPES.IntArray, TOKENS.uniform, integers(groom.root_triangles))
    _primvar(prim, "skinprimuv", TYPES.Float2Array, TOKENS.uniform, pairs(in_triangle))


def author_body(prim: UsdGeom.Mesh, mesh: Mesh) -> None:
    """Author the faces, texture coordinates and material of the body."""
    prim.CreateFaceVertexCountsAttr(Vt.IntArray(len(mesh.triangles), 3))
    prim.CreateFaceVertexIndicesAttr(integers(mesh.triangles.ravel()))
    prim.CreateSubdivisionSchemeAttr(TOKENS.none)
    prim.SetNormalsInterpolation(TOKENS.vertex)
    if mesh.uv is not None:
        values = Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(mesh.uv.reshape(-1, 2), np.float32))
        _primvar(prim, UsdUtils.GetPrimaryUVSetName(), TYPES.TexCoord2fArray, TOKENS.faceVarying, values)
    _bind(prim, "skin", SKIN_COLOUR, SKIN_ROUGHNESS, FLESH)


def _primvar(prim: UsdGeom.Gprim, name: str, kind: Sdf.ValueTypeName, interpolation: str, value: object) -> None:
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, interpolation).Set(value)


def _bind(prim: UsdGeom.Gprim, name: str, colour: Gf.Vec3f, roughness: float, ior: float) -> None:
    """Bind a plain material of its own to the prim, and set its colour, for clients that drop materials of curves.

    The binding is for all purposes: previews ignore one for `full`.
    """
    prim.CreateDisplayColorAttr([colour])
    stage = prim.GetPrim().GetStage()
    root = prim.GetPrim().GetParent().GetPath()
    looks = UsdGeom.Scope.Define(stage, root.AppendChild(UsdUtils.GetMaterialsScopeName()))
    material = UsdShade.Material.Define(stage, looks.GetPath().AppendChild(name))
    shader = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", TYPES.Color3f).Set(colour)
    shader.CreateInput("roughness", TYPES.Float).Set(roughness)
    shader.CreateInput("ior", TYPES.Float).Set(ior)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)
