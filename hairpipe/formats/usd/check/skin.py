"""Rules for the roots of hair: they lie on a skin, and move with it."""

from collections.abc import Iterator

import numpy as np
from pxr import Usd, UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.roots import Roots, authored_roots, find_roots, is_triangles
from hairpipe.formats.usd.check.scene import Scene, Snapshot

SOME = 0.005  # share of strands from which a rule reports
OUTSIDE = 1e-4  # tolerance of coordinates outside of a triangle
UV = 0.01  # tolerance of texture coordinates against those of the skin


def skin_range(scene: Scene) -> Iterator[Fault]:
    """Find roots on missing faces, or outside of their triangle."""
    for track in scene.hair:
        faces = track.first.array("primvars:skinprim")
        uv = track.first.array("primvars:skinprimuv", 2)
        meshes = [len(mesh.first.counts) for mesh in scene.skins if mesh.first.consistent]
        if faces is not None and len(faces) and meshes and len(meshes) == len(scene.skins):
            wrong = (faces < 0) | (faces >= max(meshes))
            if wrong.any():
                message = f"strand {np.argmax(wrong)} stands on face {faces[np.argmax(wrong)]}; {wrong.sum()} such"
                yield Fault(track.path("primvars:skinprim"), f"{message}, faces are 0 to {max(meshes) - 1}")
        if uv is not None and len(uv):
            wrong = (uv < -OUTSIDE).any(axis=1) | (uv > 1 + OUTSIDE).any(axis=1)
            if all(is_triangles(mesh.first) for mesh in scene.meshes):
                wrong |= uv.sum(axis=1) > 1 + OUTSIDE
            if wrong.any():
                place = ", ".join(f"{x:.3g}" for x in uv[np.argmax(wrong)])
                message = f"strand {np.argmax(wrong)} stands at {place}, outside of its face; {wrong.sum()} such"
                yield Fault(track.path("primvars:skinprimuv"), f"{message}, both are 0 or more, their sum 1 or less")


def roots_on_skin(scene: Scene) -> Iterator[Fault]:
    """Find roots off the skin, strands with their tips on it, and hair that does not move with the body."""
    for track in scene.hair:
        roots = find_roots(scene, track)
        if roots is None or not roots.reach:
            continue
        first = track.first
        off = roots.misses(first, first.code) > roots.reach
        upside = off & (roots.misses(first, first.code, tips=True) <= roots.reach)
        if upside.mean() > SOME or (upside & roots.far(first, first.code)).any():
            message = f"strand {roots.strands[np.argmax(upside)]} has its tip on the skin, not its root"
            yield Fault(track.path("points"), f"{message}; {upside.sum()} such, the root comes first", first.code)
        elif off.mean() > SOME or roots.far(first, first.code).any():
            far = roots.misses(first, first.code)
            message = (
                f"{off.sum()} of {len(off)} roots are away from {roots.mesh.prim.GetPath()}, by up to {far.max():.3g}"
            )
            yield Fault(track.path("points"), f"{message}; a root is a point of the skin", first.code)
        else:
            yield from _moves_with_skin(roots)


def _moves_with_skin(roots: Roots) -> Iterator[Fault]:
    """Find the first time at which roots are off the skin, and whether they are late."""
    still = roots.misses(roots.hair.first, roots.hair.first.code)
    for time in _times(roots):
        hair = roots.hair.at(time)
        if not (hair.sound and np.array_equal(hair.counts, roots.hair.first.counts)):
            continue
        drift = roots.misses(hair, time) - (0 if roots.authored else still)
        off = np.abs(drift) > roots.reach
        if off.mean() > SOME or roots.far(hair, time).any():
            message = (
                f"{off.sum()} of {len(off)} roots are away from {roots.mesh.prim.GetPath()}, by up to {drift.max():.3g}"
            )
            yield Fault(roots.hair.path("points"), f"{message}{_late(roots, hair, time)}", time)
            return


def _times(roots: Roots) -> list[float]:
    """Return the times of the check: samples of hair or skin in the range of those that move."""
    times = {*roots.hair.times, *roots.mesh.times}
    spans = [track.points for track in (roots.hair, roots.mesh) if track.moves]
    return sorted(t for t in times if all(span[0] <= t <= span[-1] for span in spans))


def _late(roots: Roots, hair: Snapshot, time: float) -> str:
    near = np.median(roots.misses(hair, time))
    for lag, word in ((-1.0, "earlier"), (1.0, "later")):
        if np.median(roots.misses(hair, time + lag)) < min(near / 10, roots.reach):
            return f", but on it one frame {word}; hair and body belong to one frame"
    return "; hair goes with the skin"


def root_uv(scene: Scene) -> Iterator[Fault]:
    """Find texture coordinates of roots that differ from those of the skin, or are all equal."""
    for track in scene.hair:
        roots = authored_roots(scene, track)
        st = track.first.array("primvars:st", 2)
        if st is None or len(st) != len(track.first.counts) or not np.isfinite(st).all():
            continue
        if len(st) > 1 and not np.ptp(st, axis=0).any():
            yield Fault(track.path("primvars:st"), "is the same for all strands; it is where each root stands")
            continue
        skin = None if roots is None else _skin_uv(roots)
        if roots is not None and skin is not None:
            wrong = np.abs(skin - st[roots.strands]).max(axis=1) > UV
            if wrong.mean() > SOME:
                at = int(np.argmax(wrong))
                here, there = (f"({u:.3g}, {v:.3g})" for u, v in (st[roots.strands[at]], skin[at]))
                message = f"of strand {roots.strands[at]} is {here}, where the skin has {there}; {wrong.sum()} such"
                yield Fault(track.path("primvars:st"), message)


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


RULES = (
    Rule("skin-range", "error", skin_range),
    Rule("roots", "error", roots_on_skin),
    Rule("root-uv", "warning", root_uv),
)
