"""Rules for the body: orientation of faces, smoothing, up axis."""

from collections.abc import Iterator

import numpy as np
from pxr import UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.roots import find_roots
from hairpipe.formats.usd.check.scene import Scene, Snapshot, Track

TOKENS = UsdGeom.Tokens
INWARD = -0.5  # mean cosine between normals and faces, or faces and the way out
AWAY = 0.2  # share of faces with opposite normals that is accepted
UNIT, SOME = 0.1, 0.05  # tolerance of the length of normals, and share of faces that may exceed it
UPRIGHT = 0.3  # of a size, by which the scalp lies above the middle, or hair below the scalp


def subdivision(scene: Scene) -> Iterator[Fault]:
    """Find meshes that are smoothed by default: triangles shrink, normals are ignored, and roots are off the skin."""
    for track in scene.meshes:
        mesh = track.first
        scheme = UsdGeom.Mesh(track.prim).GetSubdivisionSchemeAttr().Get()
        if scheme == TOKENS.none or not len(mesh.counts):
            continue
        if track.prim.GetAttribute("normals").HasAuthoredValue():
            yield Fault(track.path("subdivisionScheme"), f"is {scheme}, which ignores the normals; use none")
        elif scheme == TOKENS.catmullClark and len(mesh.counts) > 3 and (mesh.counts == 3).all():
            yield Fault(track.path("subdivisionScheme"), f"is {scheme}, on triangles alone; use none")


def normals(scene: Scene) -> Iterator[Fault]:
    """Find normals opposite to the faces, and skins with inward faces."""
    skins = {roots.mesh.prim.GetPath() for hair in scene.hair if (roots := find_roots(scene, hair))}
    for track in scene.meshes:
        mesh = track.first
        faces = _face_normals(mesh)
        if faces is None:
            continue
        centres, areas, outward = faces
        authored = _authored_normals(mesh)
        lengths = None if authored is None else np.linalg.norm(authored.astype(np.float64), axis=1)
        if lengths is not None and (np.abs(lengths - 1) > UNIT).mean() > SOME:
            message = f"are {np.median(lengths):.3g} long in the median; unit vectors are right"
            yield Fault(track.path("normals"), message, mesh.code)
        elif authored is not None and _mean_cosine(authored, outward, areas) < INWARD:
            yield Fault(track.path("normals"), "look the other way than the faces; outward is right", mesh.code)
        elif authored is not None and (away := (np.einsum("fx,fx->f", authored, outward) < 0).mean()) > AWAY:
            yield Fault(track.path("normals"), f"look away from {away:.0%} of the faces; outward is right", mesh.code)
        elif track.prim.GetPath() in skins and _outward(centres, areas, outward) < INWARD:
            message = "make faces that look inward; corners go counter-clockwise seen from outside"
            yield Fault(track.path("faceVertexIndices"), message, mesh.code)


def _face_normals(mesh: Snapshot) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return centres (f, 3), areas (f,) and unit normals (f, 3) of the first triangle of each face."""
    whole = mesh.consistent and len(mesh.counts) and (mesh.counts > 2).all() and len(mesh.points)
    if not whole or mesh.corners.min() < 0 or mesh.corners.max() >= len(mesh.points):
        return None
    firsts = np.cumsum(mesh.counts) - mesh.counts
    a, b, c = (mesh.points[mesh.corners[firsts + i]].astype(np.float64) for i in range(3))
    cross = np.cross(b - a, c - a)
    if UsdGeom.Gprim(mesh.prim).GetOrientationAttr().Get() == TOKENS.leftHanded:
        cross = -cross
    areas = np.linalg.norm(cross, axis=1)
    return (a + b + c) / 3, areas, cross / np.maximum(areas, np.finfo(np.float64).tiny)[:, None]


def _authored_normals(mesh: Snapshot) -> np.ndarray | None:
    """Return the authored normal at the first corner of each face, (f, 3), None where there is none."""
    given = mesh.array("normals", 3)
    firsts = np.cumsum(mesh.counts) - mesh.counts
    corners = {TOKENS.vertex: mesh.corners[firsts], TOKENS.varying: mesh.corners[firsts]}
    corners |= {TOKENS.faceVarying: firsts, TOKENS.uniform: np.arange(len(mesh.counts))}
    interpolation = UsdGeom.PointBased(mesh.prim).GetNormalsInterpolation()
    if given is None or interpolation not in corners or len(given) != mesh.size(interpolation):
        return None
    return given[corners[interpolation]]


def _mean_cosine(these: np.ndarray, those: np.ndarray, weights: np.ndarray) -> float:
    """Return the weighted mean cosine of two fields of directions, 0 without values."""
    lengths = np.linalg.norm(these.astype(np.float64), axis=1)
    cosines = (these * those).sum(axis=1) / np.maximum(lengths, np.finfo(np.float64).tiny)
    known = np.isfinite(cosines) & np.isfinite(weights)
    return float(np.average(cosines[known], weights=weights[known])) if weights[known].sum() > 0 else 0.0


def _outward(centres: np.ndarray, areas: np.ndarray, faces: np.ndarray) -> float:
    """Return the volume over that of a body of as large a box: below 0 for inward faces."""
    away = centres - (centres.min(axis=0) + centres.max(axis=0)) / 2
    return _mean_cosine(away, faces, areas * np.linalg.norm(away, axis=1))


def up_axis(scene: Scene) -> Iterator[Fault]:
    """Find a wrong up axis: hair grows on top, hangs down, and a body is higher than deep."""
    up = "XYZ".index(UsdGeom.GetStageUpAxis(scene.stage))
    for track in scene.hair:
        roots = find_roots(scene, track)
        if roots is None or not track.first.sound:
            continue
        signs = _ways_up(track, scene.place(roots.mesh, track.first.code))
        axis = int(np.argmax([sum(sign[i] for sign in signs) for i in range(3)]))
        ours, theirs = (sum(sign[i] for sign in signs) for i in (up, axis))
        if axis != up and ours <= 0 and theirs >= 2:
            message = f"upAxis is {'XYZ'[up]}, but {roots.mesh.prim.GetPath()} stands along {'XYZ'[axis]}"
            yield Fault("/", message)


def _ways_up(track: Track, body: np.ndarray) -> list[np.ndarray]:
    """Return the votes for each axis as up axis, 1, and against it, -1: (3,) each."""
    hair = track.first
    size = np.maximum(np.ptp(body, axis=0), np.finfo(np.float64).tiny)
    roots, tips = hair.placed[hair.roots], hair.placed[hair.tips]
    above = (roots.mean(axis=0) - (body.min(axis=0) + body.max(axis=0)) / 2) / size
    below = (roots - tips).mean(axis=0) / max(np.median(np.linalg.norm(tips - roots, axis=1)), 1e-30)
    tallest = np.zeros(3)
    tallest[np.argmax(size)] = size.max() > (1 + UPRIGHT) * np.median(size)
    return [np.sign(np.where(np.abs(x) > UPRIGHT, x, 0)) for x in (above, below)] + [tallest]


RULES = (
    Rule("subdivision", "warning", subdivision),
    Rule("normals", "error", normals),
    Rule("up-axis", "warning", up_axis),
)
