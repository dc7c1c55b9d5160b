"""Rules for the body under hair: faces, normals, up axis, visibility, holes, roots on the skin, and its level sets."""

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdVol

from hairpipe.formats.usd.check.scene import TINY, TOKENS, Fault, Roots, Scene, Snapshot, Track, fault_of, notes_of
from hairpipe.formats.usd.check.stage_rules import why_hidden
from hairpipe.formats.usd.stage import spaces_of
from hairpipe.plain_file import special

INWARD = -0.5  # mean cosine between normals and faces, or faces and the way out
AWAY = 0.2  # share of faces with opposite normals that is accepted
UNIT, UNEVEN = 0.1, 0.05  # tolerance of the length of normals, and share of faces that may exceed it
UPRIGHT = 0.3  # of a size, by which the scalp lies above the middle, or hair below the scalp
TORN = 0.15  # share of edges with one face, which a bust that is cut off does not reach
FEW = 50  # faces, of which the rim of a patch is a large share
SOME = 0.005  # share of strands from which a rule reports
OUTSIDE = 1e-4  # tolerance of coordinates outside of a triangle
UV = 0.01  # tolerance of texture coordinates against those of the skin
LEAST = 1000  # bytes of a file that holds a level set
MOVED = 1e-3  # of its size, by which a body has moved


def subdivision(scene: Scene) -> Iterator[Fault]:
    """Find meshes that are smoothed by default: triangles shrink, normals are ignored, and roots are off the skin."""
    for track in scene.meshes:
        mesh = track.first
        scheme = UsdGeom.Mesh(track.prim).GetSubdivisionSchemeAttr().Get()
        if scheme == TOKENS.none or not len(mesh.counts):
            continue
        if track.has("normals"):
            yield track.fault("subdivisionScheme", f"is {scheme}, which ignores the normals; use none")
        elif scheme == TOKENS.catmullClark and len(mesh.counts) > 3 and (mesh.counts == 3).all():
            yield track.fault("subdivisionScheme", f"is {scheme}, on triangles alone; use none")


def normals(scene: Scene) -> Iterator[Fault]:
    """Find normals opposite to the faces, and skins with inward faces."""
    skins = {roots.mesh.prim.GetPath() for hair in scene.hair if (roots := scene.roots(hair))}
    for track in scene.meshes:
        mesh = track.first
        faces = _face_normals(mesh)
        if faces is None:
            continue
        centres, areas, outward = faces
        authored = _authored_normals(mesh)
        lengths = None if authored is None else np.linalg.norm(authored.astype(np.float64), axis=1)
        if lengths is not None and (np.abs(lengths - 1) > UNIT).mean() > UNEVEN:
            yield mesh.fault("normals", f"are {np.median(lengths):.3g} long in the median; unit vectors are right")
        elif authored is not None and _mean_cosine(authored, outward, areas) < INWARD:
            yield mesh.fault("normals", "look the other way than the faces; outward is right")
        elif authored is not None and (share := (np.einsum("fx,fx->f", authored, outward) < 0).mean()) > AWAY:
            yield mesh.fault("normals", f"look away from {share:.0%} of the faces; outward is right")
        elif track.prim.GetPath() in skins:
            away = centres - (centres.min(axis=0) + centres.max(axis=0)) / 2
            if _mean_cosine(away, outward, areas * np.linalg.norm(away, axis=1)) < INWARD:
                message = "make faces that look inward; corners go counter-clockwise seen from outside"
                yield mesh.fault("faceVertexIndices", message)


def _face_normals(mesh: Snapshot) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return centres (f, 3), areas (f,) and unit normals (f, 3) of the first triangle of each face."""
    if not (mesh.faces and (mesh.counts > 2).all()):
        return None
    a, b, c = (mesh.points[mesh.corners[mesh.roots + i]].astype(np.float64) for i in range(3))
    cross = np.cross(b - a, c - a)
    if UsdGeom.Gprim(mesh.prim).GetOrientationAttr().Get() == TOKENS.leftHanded:
        cross = -cross
    areas = np.linalg.norm(cross, axis=1)
    return (a + b + c) / 3, areas, cross / np.maximum(areas, TINY)[:, None]


def _authored_normals(mesh: Snapshot) -> np.ndarray | None:
    """Return the authored normal at the first corner of each face, (f, 3), None where there is none."""
    given = mesh.array("normals", 3)
    corners = dict.fromkeys((TOKENS.vertex, TOKENS.varying), mesh.corners[mesh.roots])
    corners |= {TOKENS.faceVarying: mesh.roots, TOKENS.uniform: np.arange(len(mesh.counts))}
    interpolation = UsdGeom.PointBased(mesh.prim).GetNormalsInterpolation()
    if given is None or interpolation not in corners or len(given) != mesh.size(interpolation):
        return None
    return given[corners[interpolation]]


def _mean_cosine(these: np.ndarray, those: np.ndarray, weights: np.ndarray) -> float:
    """Return the weighted mean cosine of two fields of directions, 0 without values."""
    lengths = np.linalg.norm(these.astype(np.float64), axis=1)
    cosines = (these * those).sum(axis=1) / np.maximum(lengths, TINY)
    known = np.isfinite(cosines) & np.isfinite(weights)
    return float(np.average(cosines[known], weights=weights[known])) if weights[known].sum() > 0 else 0.0


def up_axis(scene: Scene) -> Iterator[Fault]:
    """Find a wrong up axis: hair grows on top, hangs down, and a body is higher than deep."""
    up = "XYZ".index(UsdGeom.GetStageUpAxis(scene.stage))
    for track in scene.hair:
        roots = scene.roots(track)
        if roots is None or not track.first.sound:
            continue
        signs = _ways_up(track, scene.place(roots.mesh, track.first.code))
        axis = int(np.argmax([sum(sign[i] for sign in signs) for i in range(3)]))
        ours, theirs = (sum(sign[i] for sign in signs) for i in (up, axis))
        if axis != up and ours <= 0 and theirs >= 2:
            yield Fault("/", f"upAxis is {'XYZ'[up]}, but {roots.mesh.prim.GetPath()} stands along {'XYZ'[axis]}")


def _ways_up(track: Track, body: np.ndarray) -> list[np.ndarray]:
    """Return the votes for each axis as up axis, 1, and against it, -1: (3,) each."""
    hair = track.first
    size = np.maximum(np.ptp(body, axis=0), TINY)
    roots, tips = hair.placed[hair.roots], hair.placed[hair.tips]
    above = (roots.mean(axis=0) - (body.min(axis=0) + body.max(axis=0)) / 2) / size
    below = (roots - tips).mean(axis=0) / max(np.median(np.linalg.norm(tips - roots, axis=1)), 1e-30)
    tallest = np.zeros(3)
    tallest[np.argmax(size)] = size.max() > (1 + UPRIGHT) * np.median(size)
    return [np.sign(np.where(np.abs(x) > UPRIGHT, x, 0)) for x in (above, below)] + [tallest]


def body_drawn(scene: Scene) -> Iterator[Fault]:
    """Find a noted body, or the only skin of hair, that is missing or not drawn."""
    path = notes_of(scene.stage).get("body")
    known = isinstance(path, str) and Sdf.Path.IsValidPathString(path) and path.startswith("/")
    noted = Sdf.Path(path) if known else None
    body = scene.stage.GetPrimAtPath(noted or Sdf.Path.emptyPath)
    if noted and scene.hair and not body and not scene.meshes:
        yield Fault(str(noted), "is missing: the stage was written with a body there, and has no other mesh")
    hidden = {body.GetPath(): why_hidden(body, UsdGeom.Mesh)} if body else {}
    for roots in filter(None, (scene.authored_roots(track) for track in scene.hair)):
        reason = why_hidden(roots.mesh.prim, UsdGeom.Mesh)
        if reason and not reason[2] and not any(mesh.prim != roots.mesh.prim for mesh in scene.meshes):
            hidden[roots.mesh.prim.GetPath()] = reason
    for path, reason in hidden.items():
        if reason and scene.hair:
            yield Fault(str(path), f"{reason[0]}; hair on it is drawn, and the body is not", reason[1])


def holes(scene: Scene) -> Iterator[Fault]:
    """Find skins with faces that are declared holes, or that miss faces all over."""
    skins = {roots.mesh.prim.GetPath(): roots for hair in scene.hair if (roots := scene.roots(hair))}
    for roots in skins.values():
        mesh = roots.mesh.first
        declared = mesh.array("holeIndices")
        if declared is not None and len(declared):
            named = roots.hair.first.array("primvars:skinprim")
            standing = 0 if named is None else int(np.isin(named, declared).sum())
            message = f"declares {len(declared)} of {len(mesh.counts)} faces holes, on which {standing} strands stand"
            yield roots.mesh.fault("holeIndices", message)
            continue
        rim, edges = _rim(mesh)
        if len(mesh.counts) > FEW and rim > TORN * edges:
            message = f"leaves {rim} of {edges} edges with one face: faces are missing"
            yield roots.mesh.fault("faceVertexIndices", message)


def _rim(mesh: Snapshot) -> tuple[int, int]:
    """Return the number of edges with one face, and of all; points in one place are merged."""
    if not mesh.faces:
        return 0, 0
    corners = mesh.corners
    _, place = np.unique(mesh.points, axis=0, return_inverse=True)
    begins = place.ravel()[corners]
    after = np.arange(len(corners)) + 1
    filled = mesh.counts > 0
    after[mesh.tips[filled]] = mesh.roots[filled]
    edges = np.sort(np.stack([begins, begins[after]], axis=1), axis=1)
    edges = edges[edges[:, 0] != edges[:, 1]]
    _, faces = np.unique(edges, axis=0, return_counts=True)
    return int((faces == 1).sum()), len(faces)


def skin_range(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find roots on missing faces, or outside of their triangle."""
    faces = track.first.array("primvars:skinprim")
    uv = track.first.array("primvars:skinprimuv", 2)
    meshes = [len(mesh.first.counts) for mesh in scene.skins if mesh.first.consistent]
    if faces is not None and len(faces) and meshes and len(meshes) == len(scene.skins):
        wrong = (faces < 0) | (faces >= max(meshes))
        if wrong.any():
            message = f"strand {np.argmax(wrong)} stands on face {faces[np.argmax(wrong)]}; {wrong.sum()} such"
            yield track.fault("primvars:skinprim", f"{message}, faces are 0 to {max(meshes) - 1}")
    if uv is not None and len(uv):
        wrong = (uv < -OUTSIDE).any(axis=1) | (uv > 1 + OUTSIDE).any(axis=1)
        if all(mesh.first.triangles for mesh in scene.meshes):
            wrong |= uv.sum(axis=1) > 1 + OUTSIDE
        if wrong.any():
            place = ", ".join(f"{x:.3g}" for x in uv[np.argmax(wrong)])
            message = f"strand {np.argmax(wrong)} stands at {place}, outside of its face; {wrong.sum()} such"
            yield track.fault("primvars:skinprimuv", f"{message}, both are 0 or more, their sum 1 or less")


def roots_on_skin(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find roots off the skin, strands with their tips on it, and hair that does not move with the body."""
    roots = scene.roots(track)
    if roots is None or not roots.reach:
        return
    first = track.first
    off = roots.misses(first, first.code) > roots.reach
    upside = off & (roots.misses(first, first.code, tips=True) <= roots.reach)
    if upside.mean() > SOME or (upside & roots.far(first, first.code)).any():
        message = f"strand {roots.strands[np.argmax(upside)]} has its tip on the skin, not its root"
        yield track.fault("points", f"{message}; {upside.sum()} such, the root comes first", first.code)
    elif off.mean() > SOME or roots.far(first, first.code).any():
        yield first.fault(
            "points", f"{_away(roots, off, roots.misses(first, first.code))}; a root is a point of the skin"
        )
    else:
        yield from _moves_with_skin(roots)


def _moves_with_skin(roots: Roots) -> Iterator[Fault]:
    """Find the first time at which roots are off the skin, and whether they are late."""
    still = roots.misses(roots.hair.first, roots.hair.first.code)
    times = {*roots.hair.times, *roots.mesh.times}
    spans = [track.points for track in (roots.hair, roots.mesh) if track.moves]
    for time in sorted(t for t in times if all(span[0] <= t <= span[-1] for span in spans)):
        hair = roots.hair.at(time)
        if not (hair.sound and np.array_equal(hair.counts, roots.hair.first.counts)):
            continue
        drift = roots.misses(hair, time) - (0 if roots.authored else still)
        off = np.abs(drift) > roots.reach
        if off.mean() > SOME or roots.far(hair, time).any():
            yield hair.fault("points", f"{_away(roots, off, drift)}{_late(roots, hair, time)}")
            return


def _away(roots: Roots, off: np.ndarray, misses: np.ndarray) -> str:
    where = roots.mesh.prim.GetPath()
    return f"{off.sum()} of {len(off)} roots are away from {where}, by up to {misses.max():.3g}"


def _late(roots: Roots, hair: Snapshot, time: float) -> str:
    near = np.median(roots.misses(hair, time))
    for lag, word in ((-1.0, "earlier"), (1.0, "later")):
        if np.median(roots.misses(hair, time + lag)) < min(near / 10, roots.reach):
            return f", but on it one frame {word}; hair and body belong to one frame"
    return "; hair goes with the skin"


def root_uv(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find texture coordinates of roots that differ from those of the skin, or are all equal."""
    roots = scene.authored_roots(track)
    st = track.first.array("primvars:st", 2)
    if st is None or len(st) != len(track.first.counts) or not np.isfinite(st).all():
        return
    if len(st) > 1 and not np.ptp(st, axis=0).any():
        yield track.fault("primvars:st", "is the same for all strands; it is where each root stands")
        return
    skin = None if roots is None else _skin_uv(roots)
    if roots is not None and skin is not None:
        wrong = np.abs(skin - st[roots.strands]).max(axis=1) > UV
        if wrong.mean() > SOME:
            at = int(np.argmax(wrong))
            here, there = (f"({u:.3g}, {v:.3g})" for u, v in (st[roots.strands[at]], skin[at]))
            message = f"of strand {roots.strands[at]} is {here}, where the skin has {there}; {wrong.sum()} such"
            yield track.fault("primvars:st", message)


def _skin_uv(roots: Roots) -> np.ndarray | None:
    """Return the texture coordinates of the skin at its roots, (s, 2), None where it has none a corner."""
    primvar = UsdGeom.PrimvarsAPI(roots.mesh.prim).GetPrimvar("st")
    corners = roots.mesh.first.corners
    if not primvar.HasValue() or primvar.GetInterpolation() != UsdGeom.Tokens.faceVarying:
        return None
    st = np.asarray(primvar.ComputeFlattened(Usd.TimeCode.EarliestTime()))
    faces = roots.hair.first.array("primvars:skinprim")
    if st.shape != (len(corners), 2) or faces is None:
        return None
    return np.einsum("sk,skx->sx", roots.weights, st.reshape(-1, 3, 2)[faces[roots.strands].astype(np.int64)])


def volume_still(scene: Scene) -> Iterator[Fault]:
    """Find one level set for all frames while the body moves: one file, or files of one content."""
    if not any(_has_moved(scene, mesh) for mesh in scene.meshes):
        return
    for prim in scene.stage.Traverse():
        if not prim.IsA(UsdVol.OpenVDBAsset) or any(s.TransformMightBeTimeVarying() for s in spaces_of(prim)):
            continue
        attribute = UsdVol.OpenVDBAsset(prim).GetFilePathAttr()
        times = attribute.GetTimeSamples()
        assets = [attribute.Get(time) for time in times] if times else [attribute.Get()]
        files = {asset.path for asset in assets if asset}
        contents = {_content(asset) for asset in assets if asset}
        if len(files) == 1 or (len(contents) == 1 and None not in contents):
            yield fault_of(attribute, "is one level set at all frames, but the body moves; export one a frame")


def _has_moved(scene: Scene, mesh: Track) -> bool:
    """Return whether a mesh has moved at its last time, or at half of its times."""
    stage = scene.stage
    span = [stage.GetStartTimeCode(), stage.GetEndTimeCode()] if stage.HasAuthoredTimeCodeRange() else []
    times = mesh.points if mesh.moves else span
    if not scene.moves(mesh) or len(times) < 2:
        return False
    places = [scene.place(mesh, time) for time in (times[0], times[len(times) // 2], times[-1])]
    size = float(np.linalg.norm(np.ptp(places[0], axis=0))) if len(places[0]) else 0.0
    return any(len(p) == len(places[0]) and np.abs(p - places[0]).max() > MOVED * size for p in places[1:] if size)


def _content(asset: Sdf.AssetPath) -> bytes | None:
    """Return a digest of a file; None where it is not one, or too small to hold a level set."""
    path = Path(asset.resolvedPath)
    if not asset.resolvedPath or special(path) or not path.is_file() or path.stat().st_size < LEAST:
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "blake2b").digest()
