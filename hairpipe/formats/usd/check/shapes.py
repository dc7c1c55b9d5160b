"""Rules for curves and meshes at one time."""

from collections.abc import Iterator, Sized

import numpy as np
from pxr import UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import Snapshot

TOKENS = UsdGeom.Tokens
USUAL = {"pref": TOKENS.vertex, "hairId": TOKENS.uniform, "st": TOKENS.uniform}
"""Interpolation of values of hair: one rest position per point, one id and one place on the skin per strand."""
SINGLE = {"points": 3, "velocities": 3, "accelerations": 3, "normals": 3, "extent": 3, "widths": 1, "primvars:pref": 3}
"""Attributes of single precision, with their numbers of components."""
BRIGHTEST = 1.001  # largest component of a colour, with room for rounding
ALIKE = 5.0  # largest ratio of the sizes of default and sampled shapes
TOUCH, SLACK = 1e-5, 0.1  # tolerances of an extent that is too small or too large, over the box of the points


def finite(shape: Snapshot) -> Iterator[Fault]:
    """Find numbers that are not finite: a renderer may drop the whole groom for one of them."""
    for attribute in shape.prim.GetAuthoredAttributes():
        value = attribute.Get(shape.time)
        array = np.asarray(value) if attribute.GetTypeName().isArray and value is not None else np.empty(0)
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            bad = np.flatnonzero(~np.isfinite(array.reshape(len(array), -1)).all(axis=1))
            message = f"element {bad[0]}{_owner(shape, attribute.GetName(), bad[0])} is not finite; {len(bad)} such"
            yield Fault(str(attribute.GetPath()), message, shape.code)


def doubles(shape: Snapshot) -> Iterator[Fault]:
    """Find points and their like with values of doubles; OpenUSD validates the declared types of the schema only."""
    for name, columns in SINGLE.items():
        array = shape.array(name, columns)
        if array is None or array.dtype != np.float64:
            continue
        attribute = shape.prim.GetAttribute(name)
        if all(spec.typeName == attribute.GetTypeName() for spec in attribute.GetPropertyStack()):
            yield Fault(shape.path(name), "has values of doubles, which clients drop; floats are right", shape.code)


def colours(shape: Snapshot) -> Iterator[Fault]:
    """Find colours of 0 to 255 in place of 0 to 1: everything is white."""
    for name in ("primvars:displayColor", "primvars:groom_color"):
        array = shape.array(name, 3)
        if array is not None and array.max(initial=0) > BRIGHTEST:
            message = f"is up to {array.max():.4g}; 0 to 1 is right, and 255 is 1"
            yield Fault(shape.path(name), message, shape.code)


def _owner(shape: Snapshot, name: str, element: int) -> str:
    if not (shape.curves and shape.consistent and name in ("points", "velocities")):
        return ""
    return f" of curve {np.searchsorted(np.cumsum(shape.counts), element, side='right')}"


def mesh_faces(shape: Snapshot) -> Iterator[Fault]:
    """Find faces whose corners are missing, or are not points."""
    if shape.curves:
        return
    corners = shape.corners
    if not (len(shape.points) and len(shape.counts)):
        yield Fault(str(shape.prim.GetPath()), "has no points or no faces", shape.code)
    elif not shape.consistent:
        message = f"sums to {shape.counts.sum()}, but there are {len(corners)} faceVertexIndices"
        yield Fault(shape.path("faceVertexCounts"), message, shape.code)
    elif (shape.counts < 3).any():
        message = f"face {np.argmin(shape.counts)} has {shape.counts.min()} corners; it takes 3"
        yield Fault(shape.path("faceVertexCounts"), message, shape.code)
    elif len(corners) and not (corners.min() >= 0 and corners.max() < len(shape.points)):
        message = f"spans {corners.min()} to {corners.max()}, but there are {len(shape.points)} points"
        yield Fault(shape.path("faceVertexIndices"), message, shape.code)


def element_count(shape: Snapshot) -> Iterator[Fault]:
    """Find velocities, normals and primvars that have more or fewer elements than the shape."""
    if not shape.consistent:
        return
    for name in ("velocities", "accelerations"):
        array = shape.array(name, 3)
        yield from _count(shape, name, array, TOKENS.vertex)
    normals = UsdGeom.PointBased(shape.prim).GetNormalsInterpolation()
    yield from _count(shape, "normals", shape.array("normals", 3), normals)
    for primvar in UsdGeom.PrimvarsAPI(shape.prim).GetPrimvarsWithAuthoredValues():
        value = primvar.ComputeFlattened(shape.time) if primvar.IsIndexed() else primvar.Get(shape.time)
        if primvar.GetTypeName().isArray:
            tuples = primvar.GetElementSize()
            yield from _count(shape, primvar.GetName(), value, primvar.GetInterpolation(), tuples)


def _count(shape: Snapshot, name: str, array: Sized | None, interpolation: str, tuples: int = 1) -> Iterator[Fault]:
    wanted = shape.size(interpolation) * tuples
    if array is not None and len(array) != wanted:
        message = f"has {len(array)} elements; {interpolation} interpolation takes {wanted}"
        yield Fault(shape.path(name), message, shape.code)


def hair_interpolation(shape: Snapshot) -> Iterator[Fault]:
    """Find rest positions, ids and root coordinates with an interpolation that other programs do not read."""
    for name, wanted in USUAL.items() if shape.curves else ():
        primvar = UsdGeom.PrimvarsAPI(shape.prim).GetPrimvar(name)
        if primvar.HasAuthoredValue() and primvar.GetInterpolation() != wanted:
            yield Fault(shape.path(primvar.GetName()), f"interpolation is {primvar.GetInterpolation()}; use {wanted}")


def extent(shape: Snapshot) -> Iterator[Fault]:
    """Find an extent that cuts the shape off, or is far too large."""
    box = shape.array("extent", 3)
    if not (shape.consistent and len(shape.points) and np.isfinite(shape.points).all()) or box is None or len(box) != 2:
        return
    thick = _half_width(shape)
    lower = shape.points.min(axis=0) - thick
    upper = shape.points.max(axis=0) + thick
    size = np.linalg.norm(upper - lower)
    outside = np.maximum(box[0] - lower, upper - box[1]).max()
    if not outside <= TOUCH * size + np.abs(box).max() * 1e-6:
        yield Fault(shape.path("extent"), f"leaves out {outside:.3g} of the shape and its half width", shape.code)
    elif np.maximum(lower - box[0], box[1] - upper).max() > SLACK * size + 4 * thick:
        yield Fault(shape.path("extent"), "is much larger than the shape", shape.code)


def extent_missing(shape: Snapshot) -> Iterator[Fault]:
    """Find shapes without an extent."""
    box = shape.array("extent", 3)
    if len(shape.points) and (box is None or len(box) != 2):
        yield Fault(shape.path("extent"), "has no value; clients have to read all points", shape.code)


def defaults(shape: Snapshot) -> Iterator[Fault]:
    """Find default points of another number than the samples: some clients read only the default."""
    points = shape.prim.GetAttribute("points")
    still = points.Get() if points and points.GetNumTimeSamples() and shape.consistent else None
    if still is not None and len(still) != len(shape.points):
        message = f"have {len(still)} elements without a time and {len(shape.points)} at this one"
        yield Fault(shape.path("points"), message, shape.code)
    elif still is not None and len(still) and shape.code == points.GetTimeSamples()[0]:
        sizes = [float(np.linalg.norm(np.ptp(array, axis=0))) for array in (np.asarray(still), shape.points)]
        if not sizes[1] / ALIKE <= sizes[0] <= sizes[1] * ALIKE:
            message = f"are {sizes[0]:.3g} large without a time and {sizes[1]:.3g} at this one"
            yield Fault(shape.path("points"), message, shape.code)


def _half_width(shape: Snapshot) -> float:
    values = shape.array("widths") if shape.curves else None
    values = np.empty(0) if values is None else values[np.isfinite(values)]
    return float(values.max()) / 2 if len(values) else 0.0


RULES = (
    Rule("finite", "error", finite),
    Rule("doubles", "error", doubles),
    Rule("colours", "error", colours),
    Rule("mesh-faces", "error", mesh_faces),
    Rule("element-count", "error", element_count),
    Rule("hair-interpolation", "warning", hair_interpolation),
    Rule("extent", "error", extent),
    Rule("extent", "warning", extent_missing),
    Rule("defaults", "error", defaults),
)
