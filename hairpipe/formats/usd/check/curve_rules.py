"""Rules for curves at one time."""

import re
from collections.abc import Iterator

import numpy as np
from pxr import UsdGeom

from hairpipe.formats.usd.check.finding import Fault, Rule
from hairpipe.formats.usd.check.scene import Snapshot

TOKENS = UsdGeom.Tokens
IDS = re.compile(r"(?i)(^|[:_])((hair|strand|curve|groom)?_?ids?|[a-z]+Id)$")
"""Names of ids of strands in other programs."""
FAT = 20.0  # width of a strand that is too thick, over the median
THICK = 1.5  # width of a tip that is too thick, over that of the root
SMALLEST = {TOKENS.nonperiodic: 4, TOKENS.periodic: 3, TOKENS.pinned: 2}
"""Fewest points of a cubic curve by its wrap mode."""


def curve_counts(curves: Snapshot) -> Iterator[Fault]:
    """Find curve counts that do not sum to the number of points."""
    for name, columns in (("points", 3), ("curveVertexCounts", 1)):
        if curves.array(name, columns) is None:
            yield Fault(curves.path(name), "has no value", curves.code)
            return
    if not len(curves.counts):
        yield Fault(curves.path("curveVertexCounts"), "is empty; there is no hair", curves.code)
    if not curves.consistent:
        message = f"sums to {curves.counts.sum()}, but there are {len(curves.points)} points"
        yield Fault(curves.path("curveVertexCounts"), message, curves.code)


def curve_length(curves: Snapshot) -> Iterator[Fault]:
    """Find curves of too few points for their basis, which renderers drop."""
    if not curves.consistent:
        return
    kind, basis, wrap = shape(curves)
    least = SMALLEST.get(wrap, 2) if kind == TOKENS.cubic else 2
    short = curves.counts < least
    if kind == TOKENS.cubic and basis == TOKENS.bezier:
        left = curves.counts % 3
        short |= (left != 0) if wrap == TOKENS.periodic else (left != 1) | (curves.counts < 4)
    if short.any():
        first = int(np.argmax(short))
        message = f"curve {first} has {curves.counts[first]} points, which makes no {wrap} {kind} {basis} curve"
        yield Fault(curves.path("curveVertexCounts"), f"{message}; {short.sum()} such curves", curves.code)


def hair_basis(curves: Snapshot) -> Iterator[Fault]:
    """Find curves that do not pass through their points, or leave the skin in some clients."""
    kind, basis, wrap = shape(curves)
    if kind == TOKENS.linear:
        return
    if basis != TOKENS.catmullRom:
        far = f"passes them at up to {_gap(curves):.2g}" if basis == TOKENS.bspline and curves.sound else "misses them"
        message = f"is {basis}: the curve {far}, which is right for control points; for simulated points use catmullRom"
        yield Fault(curves.path("basis"), message, curves.code)
    if wrap != TOKENS.pinned:
        yield Fault(curves.path("wrap"), f"is {wrap}, which ends before the root and the tip; use pinned", curves.code)


def _gap(curves: Snapshot) -> float:
    """Return the largest distance of a uniform cubic B-spline from its inner control points, in their unit."""
    points = curves.points.astype(np.float64)
    inner = np.ones(max(len(points) - 2, 0), bool)
    for ends in (curves.roots, curves.tips):
        inner[ends[(ends > 0) & (ends < len(points) - 1)] - 1] = False
    apart = np.linalg.norm(points[:-2] - 2.0 * points[1:-1] + points[2:], axis=1) / 6.0
    return float(apart[inner].max(initial=0.0))


def widths(curves: Snapshot) -> Iterator[Fault]:
    """Find curves without a usable diameter: a missing one is drawn one unit thick."""
    values = curves.array("widths")
    if values is None or not len(values):
        yield Fault(curves.path("widths"), "has no value; every hair is drawn one unit thick", curves.code)
    elif not (values > 0).any():
        yield Fault(curves.path("widths"), "are all 0, so that nothing is drawn", curves.code)
    elif (values < 0).any():
        yield Fault(curves.path("widths"), f"element {np.argmax(values < 0)} is negative", curves.code)
    elif curves.consistent:
        interpolation = UsdGeom.Curves(curves.prim).GetWidthsInterpolation()
        wanted = curves.size(interpolation)
        if interpolation not in (TOKENS.vertex, TOKENS.constant):
            message = f"interpolation is {interpolation}, which clients count differently; use vertex or constant"
            yield Fault(curves.path("widths"), message, curves.code)
        elif len(values) != wanted:
            message = f"has {len(values)} elements; {interpolation} interpolation takes {wanted}"
            yield Fault(curves.path("widths"), message, curves.code)


def taper(curves: Snapshot) -> Iterator[Fault]:
    """Find hair that is thicker at its tip than at its root: widths in the opposite order of the points."""
    values = curves.array("widths")
    if values is None or not curves.sound or len(values) != len(curves.points):
        return
    roots, tips = values[curves.roots], values[curves.tips]
    if np.median(tips) > THICK * max(np.median(roots), 0):
        message = f"are {np.median(tips):.3g} at tips and {np.median(roots):.3g} at roots; they begin at the root"
        yield Fault(curves.path("widths"), message, curves.code)


def uneven_widths(curves: Snapshot) -> Iterator[Fault]:
    """Find strands that vanish between root and tip, and strands that are far thicker than the others."""
    values = curves.array("widths")
    if values is None or not curves.sound or len(values) != len(curves.points) or not np.isfinite(values).all():
        return
    inner = np.ones(len(values), bool)
    inner[curves.tips] = False
    gone = np.logical_or.reduceat(inner & (values == 0), curves.roots)
    thick = np.maximum.reduceat(values, curves.roots)
    fat = thick > FAT * np.median(thick)
    if (values > 0).any() and gone.any():
        message = f"of strand {np.argmax(gone)} are 0 before its tip; {gone.sum()} such strands, drawn in parts"
        yield Fault(curves.path("widths"), message, curves.code)
    elif fat.any():
        message = f"of strand {np.argmax(fat)} are {thick[np.argmax(fat)]:.3g}, others {np.median(thick):.3g}"
        yield Fault(curves.path("widths"), f"{message}; {fat.sum()} such strands", curves.code)


def two_of_one(curves: Snapshot) -> Iterator[Fault]:
    """Find primvars that some clients use in place of the attribute of the same name."""
    for name in ("points", "widths", "velocities", "normals", "accelerations"):
        primvar, own = (curves.prim.GetAttribute(n) for n in (f"primvars:{name}", name))
        if primvar and primvar.HasAuthoredValue() and own.HasAuthoredValue():
            message = f"replaces {name} in some clients and not in others; keep one"
            yield Fault(str(primvar.GetPath()), message, curves.code)


def hair_ids(curves: Snapshot) -> Iterator[Fault]:
    """Find moving hair without ids, ids that are not integers, and repeated ids."""
    attribute = curves.prim.GetAttribute("primvars:hairId")
    ids = curves.array("primvars:hairId")
    if not (attribute and attribute.HasValue()):
        moves = curves.prim.GetAttribute("points").GetNumTimeSamples() > 1
        if moves and not any(IDS.search(name) for name in curves.prim.GetAuthoredPropertyNames()):
            message = "has no value; moving strands are identified by whole numbers, one per strand"
            yield Fault(curves.path("primvars:hairId"), message)
        return
    if ids is None or ids.dtype.kind == "f":
        message = f"is of type {attribute.GetTypeName()}; whole numbers name strands, int[] is right"
        yield Fault(curves.path("primvars:hairId"), message)
        return
    names, first, seen = np.unique(ids, return_index=True, return_counts=True)
    if (seen > 1).any():
        twice = first[seen > 1].min()
        message = f"{ids[twice]} names {seen[names == ids[twice]][0]} curves; {(seen > 1).sum()} such ids"
        yield Fault(curves.path("primvars:hairId"), message, curves.code)


def lock_ids(curves: Snapshot) -> Iterator[Fault]:
    """Find followers of a missing strand or of another follower: ids of other strands, or in another order."""
    ids, followed = curves.array("primvars:hairId"), curves.array("primvars:lockId")
    if ids is None or followed is None or not len(ids) == len(followed) == len(curves.counts):
        return
    unknown = ~np.isin(followed, ids)
    leads = np.isin(ids, followed)
    chained = leads & (followed != ids)
    if unknown.any():
        message = f"strand {np.argmax(unknown)} follows {followed[np.argmax(unknown)]}, which is not a hairId"
        yield Fault(curves.path("primvars:lockId"), f"{message}; {unknown.sum()} such strands", curves.code)
    elif chained.any():
        at = int(np.argmax(chained))
        message = f"others follow {ids[at]}, which follows {followed[at]}; {chained.sum()} such of {leads.sum()}"
        yield Fault(curves.path("primvars:lockId"), f"{message}, ids are in the order of the strands", curves.code)


def shape(curves: Snapshot) -> tuple[str, str, str]:
    """Return type, basis and wrap, as authored or as the schema has it."""
    prim = UsdGeom.BasisCurves(curves.prim)
    return prim.GetTypeAttr().Get(), prim.GetBasisAttr().Get(), prim.GetWrapAttr().Get()


RULES = (
    Rule("curve-counts", "error", curve_counts),
    Rule("curve-length", "error", curve_length),
    Rule("hair-basis", "warning", hair_basis),
    Rule("widths", "error", widths),
    Rule("taper", "warning", taper),
    Rule("widths-uneven", "warning", uneven_widths),
    Rule("two-of-one", "error", two_of_one),
    Rule("hair-ids", "error", hair_ids),
    Rule("lock-ids", "error", lock_ids),
)
