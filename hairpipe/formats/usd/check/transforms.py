"""Rules for transforms: ignored, reset, singular, or not those of the body; OpenUSD has no validators for them."""

from collections.abc import Iterator

import numpy as np
from pxr import Usd, UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import Scene, Track

PREFIX, ORDER = "xformOp:", "xformOpOrder"
RESET, INVERT = "!resetXformStack!", "!invert!"
EQUAL = 1e-3  # tolerance of equal scales
FLAT = 1e-9  # volume over the cube of the size from which a transform is singular


def transform(prim: Usd.Prim) -> Iterator[Fault]:
    """Find transforms that are not finite, or singular."""
    if prim.IsA(UsdGeom.Xformable):
        for time in _times(prim):
            world = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time))
            code = time.GetValue() if time.IsNumeric() and time != Usd.TimeCode.EarliestTime() else None
            axes = world[:3, :3]
            if not np.isfinite(world).all():
                yield Fault(str(prim.GetPath()), "the transform to the world is not finite", code)
                return
            if abs(np.linalg.det(axes)) <= FLAT * np.abs(axes).max() ** 3:
                yield Fault(str(prim.GetPath()), "the transform to the world has no volume; all is flat", code)
                return


def _times(prim: Usd.Prim) -> list[Usd.TimeCode]:
    ops = [a for a in prim.GetAuthoredAttributes() if a.GetName().startswith(PREFIX)]
    times = sorted({time for attribute in ops for time in attribute.GetTimeSamples()})
    return [Usd.TimeCode(time) for time in times] or [Usd.TimeCode.EarliestTime()]


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
        yield Fault(str(prim.GetPath()), f"resets its transform, so that it does not go with {parent.GetPath()}")


def hair_transform(scene: Scene) -> Iterator[Fault]:
    """Find hair that is mirrored, sheared, or of another scale than the body or its own widths."""
    for track in scene.hair:
        path = str(track.prim.GetPath())
        axes = track.first.world[:3, :3]
        own = np.array(UsdGeom.Xformable(track.prim).GetLocalTransformation(track.first.time))[:3, :3]
        scales = np.linalg.svd(axes, compute_uv=False)
        bodies = [_scale(mesh.first.world[:3, :3]) for mesh in scene.meshes if scene.moves(mesh) or _is_bound(track)]
        if not np.isfinite(axes).all() or not scales.all():
            continue
        if np.linalg.det(axes) < 0:
            yield Fault(path, "is mirrored by its transform; mirror the points, and keep the transform a movement")
        elif scales[0] > (1 + EQUAL) * scales[-1]:
            message = f"is scaled by {scales[0]:.3g} one way and by {scales[-1]:.3g} another"
            yield Fault(path, f"{message}; widths know one scale")
        elif bodies and all(abs(_scale(axes) / body - 1) > EQUAL for body in bodies):
            yield Fault(path, f"is scaled by {_scale(axes):.3g}, where the body is by {bodies[0]:.3g}")
        elif abs(_scale(own) - 1) > EQUAL and not bodies:
            yield Fault(path, f"is scaled by {_scale(own):.3g} of its own; scale the points, widths and velocities")


def _is_bound(track: Track) -> bool:
    return track.prim.GetAttribute("primvars:skinprim").HasAuthoredValue()


def _scale(axes: np.ndarray) -> float:
    return float(np.cbrt(abs(np.linalg.det(axes)))) or 1.0


PRIM_RULES = (
    Rule("transform", "error", transform),
    Rule("ignored-transform", "error", ignored_transform),
    Rule("reset-transform", "warning", reset_transform),
)
RULES = (Rule("hair-transform", "error", hair_transform),)
