"""Rules for size: plausible widths and lengths, and sufficient precision."""

from collections.abc import Iterator

import numpy as np
from pxr import UsdGeom, UsdVol

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import Scene, Snapshot, Track
from hairpipe.values.groom import DIAMETERS

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
        width = _width(hair, scene)
        length = float(np.median(hair.lengths)) * _scale(hair, scene)
        scalp = _box(hair.placed[hair.roots], scene) if len(hair.counts) >= FEW else None
        votes = [_side(width, WIDTH), _side(length, LENGTH), _side(scalp, SCALP), _side(body, BODY)]
        sizes = f"widths of {_text(width)}, strands of {_text(length)}" + (f", a body of {_text(body)}" if body else "")
        alone = body is not None and votes[3] == 0 and scalp is not None and scalp > body
        if abs(sum(votes)) >= 2 and alone:
            message = f"make hair of {sizes}: points and widths are in another unit than the stage"
            yield Fault(track.path("points"), message, hair.code)
        elif abs(sum(votes)) >= 2:
            what = "large" if sum(votes) > 0 else "small"
            unit = UsdGeom.GetStageMetersPerUnit(scene.stage)
            message = f"metersPerUnit is {unit:g}, which makes {sizes}: too {what}"
            yield Fault("/", message)
        elif votes[0]:
            right = f"{_text(WIDTH[0])} to {_text(WIDTH[1])} is hair"
            yield Fault(track.path("widths"), f"are {_text(width)} in the median; {right}", hair.code)
        elif votes[1]:
            right = f"{_text(LENGTH[0])} to {_text(LENGTH[1])} is hair"
            yield Fault(track.path("points"), f"make strands of {_text(length)} in the median; {right}", hair.code)


def _side(value: float | None, usual: tuple[float, float]) -> int:
    """Return -1, 0 or 1 for a value that is too small, plausible or unknown (0), or too large."""
    return 0 if not value or not np.isfinite(value) else int(value > usual[1]) - int(value < usual[0])


def _text(metres: float | None) -> str:
    return "none" if metres is None else f"{metres:.2g} m" if metres > 0.01 else f"{metres * 1000:.2g} mm"


def _scale(shape: Snapshot, scene: Scene) -> float:
    """Return the unit of the shape [m]."""
    return float(np.cbrt(abs(np.linalg.det(scene.metres[:3, :3] @ shape.world[:3, :3].T))))


def _width(hair: Snapshot, scene: Scene) -> float | None:
    """Return the median of the diameters, else of the widths, that are not 0 [m], None where there are none."""
    widths = hair.array(f"primvars:{DIAMETERS}")
    widths = hair.array("widths") if widths is None else widths
    thick = np.empty(0) if widths is None else widths[np.isfinite(widths) & (widths > 0)]
    return float(np.median(thick)) * _scale(hair, scene) if len(thick) else None


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
        ratio = sizes[0] / max(sizes[1], np.finfo(np.float64).tiny)
        apart = np.maximum(corners.min(axis=0) - body.max(axis=0), body.min(axis=0) - corners.max(axis=0)).max()
        if apart > 0 or not HULL[0] <= ratio <= HULL[1]:
            message = (
                f"is {ratio:.3g} times the size of the body" if apart <= 0 else f"is {apart:.3g} away from the body"
            )
            yield Fault(str(track.prim.GetPath()), f"{message}; both stand in one space", track.first.code)


def precision(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find points so far from the origin of their prim that rounding errors exceed the width of hair."""
    widths = hair.array("widths")
    if hair.sound and widths is not None and len(widths) and np.median(widths) > 0:
        far = float(np.abs(hair.points).max())
        step = float(np.spacing(np.float32(far)))
        if step > ROOM * np.median(widths):
            message = f"are up to {far:.3g} from the origin of the prim, where single precision has steps of {step:.1g}"
            right = "write them about a nearer origin, and move the prim by a translate in double precision"
            yield Fault(track.path("points"), f"{message}; {right}", hair.code)


def float_translate(scene: Scene) -> Iterator[Fault]:
    """Find a large translation of hair in single precision."""
    for track in scene.hair:
        widths = track.first.array("widths")
        prim = track.prim
        least = ROOM * np.median(widths) if widths is not None and len(widths) else 0.0
        while least > 0 and prim.IsA(UsdGeom.Xformable):
            for op in UsdGeom.Xformable(prim).GetOrderedXformOps():
                far = np.abs(op.Get(track.first.time) or 0.0).max() if _is_single(op) else 0.0
                if np.spacing(np.float32(far)) > least:
                    message = f"moves by {far:.3g} in steps of {np.spacing(np.float32(far)):.1g}; use double precision"
                    yield Fault(str(op.GetAttr().GetPath()), message)
            prim = prim.GetParent()


def _is_single(op: UsdGeom.XformOp) -> bool:
    single = op.GetPrecision() != UsdGeom.XformOp.PrecisionDouble
    return single and op.GetOpType() == UsdGeom.XformOp.TypeTranslate


FRAME_RULES = (Rule("precision", "warning", precision),)
RULES = (
    Rule("size", "error", plausible_size),
    Rule("volume-size", "error", volume_size),
    Rule("precision", "warning", float_translate),
)
