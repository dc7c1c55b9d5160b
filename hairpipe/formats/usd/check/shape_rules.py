"""Rules for shapes at one time: finite numbers, counts, extents, colours, plausible sizes, sufficient precision."""

from collections.abc import Iterator, Sized

import numpy as np
from pxr import UsdGeom, UsdVol

from hairpipe.formats.usd.check.scene import TINY, TOKENS, Fault, Scene, Snapshot, Track, fault_of
from hairpipe.values.groom import DIAMETERS

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
            of_points = shape.curves and shape.consistent and attribute.GetName() in ("points", "velocities")
            curve = np.searchsorted(np.cumsum(shape.counts), bad[0], side="right") if of_points else 0
            owner = f" of curve {curve}" if of_points else ""
            yield fault_of(attribute, f"element {bad[0]}{owner} is not finite; {len(bad)} such", shape.code)


def doubles(shape: Snapshot) -> Iterator[Fault]:
    """Find points and their like with values of doubles; OpenUSD validates the declared types of the schema only."""
    for name, columns in SINGLE.items():
        array = shape.array(name, columns)
        if array is None or array.dtype != np.float64:
            continue
        attribute = shape.prim.GetAttribute(name)
        if all(spec.typeName == attribute.GetTypeName() for spec in attribute.GetPropertyStack()):
            yield shape.fault(name, "has values of doubles, which clients drop; floats are right")


def colours(shape: Snapshot) -> Iterator[Fault]:
    """Find colours of 0 to 255 in place of 0 to 1: everything is white."""
    for name in ("primvars:displayColor", "primvars:groom_color"):
        array = shape.array(name, 3)
        if array is not None and array.max(initial=0) > BRIGHTEST:
            yield shape.fault(name, f"is up to {array.max():.4g}; 0 to 1 is right, and 255 is 1")


def mesh_faces(shape: Snapshot) -> Iterator[Fault]:
    """Find faces whose corners are missing, or are not points."""
    if shape.curves:
        return
    corners = shape.corners
    if not (len(shape.points) and len(shape.counts)):
        yield fault_of(shape.prim, "has no points or no faces", shape.code)
    elif not shape.consistent:
        message = f"sums to {shape.counts.sum()}, but there are {len(corners)} faceVertexIndices"
        yield shape.fault("faceVertexCounts", message)
    elif (shape.counts < 3).any():
        message = f"face {np.argmin(shape.counts)} has {shape.counts.min()} corners; it takes 3"
        yield shape.fault("faceVertexCounts", message)
    elif len(corners) and not (corners.min() >= 0 and corners.max() < len(shape.points)):
        message = f"spans {corners.min()} to {corners.max()}, but there are {len(shape.points)} points"
        yield shape.fault("faceVertexIndices", message)


def element_count(shape: Snapshot) -> Iterator[Fault]:
    """Find velocities, normals and primvars that have more or fewer elements than the shape."""
    if not shape.consistent:
        return
    for name in ("velocities", "accelerations"):
        yield from _count(shape, name, shape.array(name, 3), TOKENS.vertex)
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
        yield shape.fault(name, f"has {len(array)} elements; {interpolation} interpolation takes {wanted}")


def hair_interpolation(shape: Snapshot) -> Iterator[Fault]:
    """Find rest positions, ids and root coordinates with an interpolation that other programs do not read."""
    for name, wanted in USUAL.items() if shape.curves else ():
        primvar = UsdGeom.PrimvarsAPI(shape.prim).GetPrimvar(name)
        if primvar.HasAuthoredValue() and primvar.GetInterpolation() != wanted:
            message = f"interpolation is {primvar.GetInterpolation()}; use {wanted}"
            yield shape.fault(primvar.GetName(), message, timed=False)


def extent(shape: Snapshot) -> Iterator[Fault]:
    """Find an extent that cuts the shape off, or is far too large."""
    box = shape.array("extent", 3)
    if not (shape.consistent and len(shape.points) and np.isfinite(shape.points).all()) or box is None or len(box) != 2:
        return
    widths = shape.array("widths") if shape.curves else None
    widths = np.empty(0) if widths is None else widths[np.isfinite(widths)]
    thick = float(widths.max()) / 2 if len(widths) else 0.0
    lower = shape.points.min(axis=0) - thick
    upper = shape.points.max(axis=0) + thick
    size = np.linalg.norm(upper - lower)
    outside = np.maximum(box[0] - lower, upper - box[1]).max()
    if not outside <= TOUCH * size + np.abs(box).max() * 1e-6:
        yield shape.fault("extent", f"leaves out {outside:.3g} of the shape and its half width")
    elif np.maximum(lower - box[0], box[1] - upper).max() > SLACK * size + 4 * thick:
        yield shape.fault("extent", "is much larger than the shape")


def extent_missing(shape: Snapshot) -> Iterator[Fault]:
    """Find shapes without an extent."""
    box = shape.array("extent", 3)
    if len(shape.points) and (box is None or len(box) != 2):
        yield shape.fault("extent", "has no value; clients have to read all points")


def defaults(shape: Snapshot) -> Iterator[Fault]:
    """Find default points of another number than the samples: some clients read only the default."""
    points = shape.prim.GetAttribute("points")
    still = points.Get() if points and points.GetNumTimeSamples() and shape.consistent else None
    if still is not None and len(still) != len(shape.points):
        yield shape.fault("points", f"have {len(still)} elements without a time and {len(shape.points)} at this one")
    elif still is not None and len(still) and shape.code == points.GetTimeSamples()[0]:
        sizes = [float(np.linalg.norm(np.ptp(array, axis=0))) for array in (np.asarray(still), shape.points)]
        if not sizes[1] / ALIKE <= sizes[0] <= sizes[1] * ALIKE:
            yield shape.fault("points", f"are {sizes[0]:.3g} large without a time and {sizes[1]:.3g} at this one")


WIDTH = (1e-5, 3e-3)
LENGTH = (2e-3, 1.5)
SCALP = (0.03, 1.3)
BODY = (0.08, 30.0)
"""Accepted sizes of hair, scalp and body [m]: from down to dreadlocks, from a doll to a dragon."""
ROOM = 0.05  # allowed error of positions in single precision, over the width
HULL = (0.2, 4.0)  # accepted sizes of level sets over that of the body
FEW = 8  # fewest strands that define a scalp


def plausible_size(scene: Scene) -> Iterator[Fault]:
    """Find implausible units of a stage, and hair of other units than its stage."""
    if not UsdGeom.GetStageMetersPerUnit(scene.stage) > 0 or not UsdGeom.StageHasAuthoredMetersPerUnit(scene.stage):
        return
    body = max((_box(track.first.placed, scene) for track in scene.meshes), default=None)
    for track in scene.hair:
        hair = track.first
        if not hair.sound or not _scale(hair, scene) > 0:
            continue
        widths = hair.array(f"primvars:{DIAMETERS}")
        widths = hair.array("widths") if widths is None else widths
        thick = np.empty(0) if widths is None else widths[np.isfinite(widths) & (widths > 0)]
        width = float(np.median(thick)) * _scale(hair, scene) if len(thick) else None
        length = float(np.median(hair.lengths)) * _scale(hair, scene)
        scalp = _box(hair.placed[hair.roots], scene) if len(hair.counts) >= FEW else None
        votes = [_side(width, WIDTH), _side(length, LENGTH), _side(scalp, SCALP), _side(body, BODY)]
        sizes = f"widths of {_text(width)}, strands of {_text(length)}" + (f", a body of {_text(body)}" if body else "")
        alone = body is not None and votes[3] == 0 and scalp is not None and scalp > body
        if abs(sum(votes)) >= 2 and alone:
            yield hair.fault("points", f"make hair of {sizes}: points and widths are in another unit than the stage")
        elif abs(sum(votes)) >= 2:
            what = "large" if sum(votes) > 0 else "small"
            unit = UsdGeom.GetStageMetersPerUnit(scene.stage)
            yield Fault("/", f"metersPerUnit is {unit:g}, which makes {sizes}: too {what}")
        elif votes[0]:
            right = f"{_text(WIDTH[0])} to {_text(WIDTH[1])} is hair"
            yield hair.fault("widths", f"are {_text(width)} in the median; {right}")
        elif votes[1]:
            right = f"{_text(LENGTH[0])} to {_text(LENGTH[1])} is hair"
            yield hair.fault("points", f"make strands of {_text(length)} in the median; {right}")


def _side(value: float | None, usual: tuple[float, float]) -> int:
    """Return -1, 0 or 1 for a value that is too small, plausible or unknown (0), or too large."""
    return 0 if not value or not np.isfinite(value) else int(value > usual[1]) - int(value < usual[0])


def _text(metres: float | None) -> str:
    return "none" if metres is None else f"{metres:.2g} m" if metres > 0.01 else f"{metres * 1000:.2g} mm"


def _scale(shape: Snapshot, scene: Scene) -> float:
    """Return the unit of the shape [m]."""
    return float(np.cbrt(abs(np.linalg.det(scene.metres[:3, :3] @ shape.world[:3, :3].T))))


def _box(points: np.ndarray, scene: Scene) -> float:
    """Return the diagonal of the box of points in the world [m]."""
    scale = float(np.cbrt(abs(np.linalg.det(scene.metres[:3, :3]))))
    return float(np.linalg.norm(np.ptp(points, axis=0))) * scale if len(points) else 0.0


def volume_size(scene: Scene) -> Iterator[Fault]:
    """Find level sets of another size or at another place than the body."""
    bodies = [track.first.placed for track in scene.meshes if len(track.first.points)]
    volumes = [prim for prim in scene.stage.Traverse() if prim.IsA(UsdVol.Volume)] if bodies else []
    for track in map(Track, volumes):
        box = track.first.array("extent", 3)
        if box is None or len(box) != 2 or not np.isfinite(box).all():
            continue
        corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T @ track.first.world[:3, :3] + track.first.world[3, :3]
        body = np.concatenate(bodies)
        sizes = [float(np.linalg.norm(np.ptp(points, axis=0))) for points in (corners, body)]
        ratio = sizes[0] / max(sizes[1], TINY)
        apart = np.maximum(corners.min(axis=0) - body.max(axis=0), body.min(axis=0) - corners.max(axis=0)).max()
        if apart > 0 or not HULL[0] <= ratio <= HULL[1]:
            what = f"{apart:.3g} away from" if apart > 0 else f"{ratio:.3g} times the size of"
            yield fault_of(track.prim, f"is {what} the body; both stand in one space", track.first.code)


def precision(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find points so far from the origin of their prim that rounding errors exceed the width of hair."""
    widths = hair.array("widths")
    if widths is not None and len(widths) and np.median(widths) > 0:
        far = float(np.abs(hair.points).max())
        step = float(np.spacing(np.float32(far)))
        if step > ROOM * np.median(widths):
            message = f"are up to {far:.3g} from the origin of the prim, where single precision has steps of {step:.1g}"
            right = "write them about a nearer origin, and move the prim by a translate in double precision"
            yield hair.fault("points", f"{message}; {right}")


def float_translate(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find a large translation of hair in single precision."""
    widths = track.first.array("widths")
    prim = track.prim
    least = ROOM * np.median(widths) if widths is not None and len(widths) else 0.0
    while least > 0 and prim.IsA(UsdGeom.Xformable):
        for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
            is_double = op.GetPrecision() == UsdGeom.XformOp.PrecisionDouble
            moves = op.GetOpType() == UsdGeom.XformOp.TypeTranslate and not is_double
            far = np.abs(op.Get(track.first.time) or 0.0).max() if moves else 0.0
            if np.spacing(np.float32(far)) > least:
                message = f"moves by {far:.3g} in steps of {np.spacing(np.float32(far)):.1g}; use double precision"
                yield fault_of(op.GetAttr(), message)
        prim = prim.GetParent()
