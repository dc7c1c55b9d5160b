"""Rules for the curves of hair: counts, basis, widths, ids; constant lengths, those of the groom at rest."""

import re
from collections.abc import Iterator

import numpy as np
from pxr import UsdGeom

from hairpipe.formats.usd.check.scene import REST, TINY, TOKENS, Fault, Scene, Snapshot, Track, fault_of

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
            yield curves.fault(name, "has no value")
            return
    if not len(curves.counts):
        yield curves.fault("curveVertexCounts", "is empty; there is no hair")
    if not curves.consistent:
        message = f"sums to {curves.counts.sum()}, but there are {len(curves.points)} points"
        yield curves.fault("curveVertexCounts", message)


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
        yield curves.fault("curveVertexCounts", f"{message}; {short.sum()} such curves")


def hair_basis(curves: Snapshot) -> Iterator[Fault]:
    """Find curves that do not pass through their points, or leave the skin in some clients."""
    kind, basis, wrap = shape(curves)
    if kind == TOKENS.linear:
        return
    if basis != TOKENS.catmullRom:
        far = f"passes them at up to {_gap(curves):.2g}" if basis == TOKENS.bspline and curves.sound else "misses them"
        message = f"is {basis}: the curve {far}, which is right for control points; for simulated points use catmullRom"
        yield curves.fault("basis", message)
    if wrap != TOKENS.pinned:
        yield curves.fault("wrap", f"is {wrap}, which ends before the root and the tip; use pinned")


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
        yield curves.fault("widths", "has no value; every hair is drawn one unit thick")
    elif not (values > 0).any():
        yield curves.fault("widths", "are all 0, so that nothing is drawn")
    elif (values < 0).any():
        yield curves.fault("widths", f"element {np.argmax(values < 0)} is negative")
    elif curves.consistent:
        interpolation = UsdGeom.Curves(curves.prim).GetWidthsInterpolation()
        wanted = curves.size(interpolation)
        if interpolation not in (TOKENS.vertex, TOKENS.constant):
            message = f"interpolation is {interpolation}, which clients count differently; use vertex or constant"
            yield curves.fault("widths", message)
        elif len(values) != wanted:
            yield curves.fault("widths", f"has {len(values)} elements; {interpolation} interpolation takes {wanted}")


def taper(curves: Snapshot) -> Iterator[Fault]:
    """Find hair that is thicker at its tip than at its root: widths in the opposite order of the points."""
    values = curves.array("widths")
    if values is None or not curves.sound or len(values) != len(curves.points):
        return
    roots, tips = values[curves.roots], values[curves.tips]
    if np.median(tips) > THICK * max(np.median(roots), 0):
        message = f"are {np.median(tips):.3g} at tips and {np.median(roots):.3g} at roots; they begin at the root"
        yield curves.fault("widths", message)


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
        yield curves.fault("widths", message)
    elif fat.any():
        message = f"of strand {np.argmax(fat)} are {thick[np.argmax(fat)]:.3g}, others {np.median(thick):.3g}"
        yield curves.fault("widths", f"{message}; {fat.sum()} such strands")


def two_of_one(curves: Snapshot) -> Iterator[Fault]:
    """Find primvars that some clients use in place of the attribute of the same name."""
    for name in ("points", "widths", "velocities", "normals", "accelerations"):
        primvar, own = (curves.prim.GetAttribute(n) for n in (f"primvars:{name}", name))
        if primvar and primvar.HasAuthoredValue() and own.HasAuthoredValue():
            yield fault_of(primvar, f"replaces {name} in some clients and not in others; keep one", curves.code)


def hair_ids(curves: Snapshot) -> Iterator[Fault]:
    """Find moving hair without ids, ids that are not integers, and repeated ids."""
    attribute = curves.prim.GetAttribute("primvars:hairId")
    ids = curves.array("primvars:hairId")
    if not (attribute and attribute.HasValue()):
        moves = curves.prim.GetAttribute("points").GetNumTimeSamples() > 1
        if moves and not any(IDS.search(name) for name in curves.prim.GetAuthoredPropertyNames()):
            message = "has no value; moving strands are identified by whole numbers, one per strand"
            yield curves.fault("primvars:hairId", message, timed=False)
        return
    if ids is None or ids.dtype.kind == "f":
        message = f"is of type {attribute.GetTypeName()}; whole numbers name strands, int[] is right"
        yield curves.fault("primvars:hairId", message, timed=False)
        return
    names, first, seen = np.unique(ids, return_index=True, return_counts=True)
    if (seen > 1).any():
        twice = first[seen > 1].min()
        message = f"{ids[twice]} names {seen[names == ids[twice]][0]} curves; {(seen > 1).sum()} such ids"
        yield curves.fault("primvars:hairId", message)


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
        yield curves.fault("primvars:lockId", f"{message}; {unknown.sum()} such strands")
    elif chained.any():
        at = int(np.argmax(chained))
        message = f"others follow {ids[at]}, which follows {followed[at]}; {chained.sum()} such of {leads.sum()}"
        yield curves.fault("primvars:lockId", f"{message}, ids are in the order of the strands")


def shape(curves: Snapshot) -> tuple[str, str, str]:
    """Return type, basis and wrap, as authored or as the schema has it."""
    prim = UsdGeom.BasisCurves(curves.prim)
    return prim.GetTypeAttr().Get(), prim.GetBasisAttr().Get(), prim.GetWrapAttr().Get()


COLLAPSED = 0.01  # of the median length
COINCIDENT = 1e-3  # of a strand's mean segment
OTHER = (0.5, 2.0)  # lengths of a strand over that at rest of the same strand
STRETCH = (0.8, 1.25)  # lengths of all strands over time
APART = 8.0  # length ratio of a segment over time from which a single strand is reported
TORN = (0.2, 2.0)  # of one segment over time
SPIKE, ALONE = 8.0, 40.0  # length over the other segments of a strand: of many strands, and of a single one
LEAST = 3  # fewest points of a strand with an outlier
BEND, OPPOSITE = 0.2, -0.7  # change of direction over a segment, and cosine between two, of a zigzag
ALTERNATING = 3  # fewest pairs of opposite changes in a row
SOME = 0.01  # share of strands from which a rule reports
SHORT = 0.2  # of the median length: shorter segments are ignored
MUCH = 4.0  # ratio of misfits of tips and roots from which strands are reversed
ROUGH = 0.01  # of a segment: step of a visible lattice
OTHERS, PARTED = 0.05, 3.0  # share of strands with other neighbours, and distance ratio of these
MANY = 500  # number of roots whose neighbours are found
MIRROR = np.array([-1, 1, 1], np.float32)
FEW = 8  # fewest places that define a lattice
ON_LATTICE = 0.02  # tolerance of a lattice in single precision, over its step


def collapsed(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find strands without length, and coincident points of a strand."""
    short = _short(hair)
    alike = _coincident(hair)
    if short.any():
        message = f"strand {np.argmax(short)} has no length; {short.sum()} such, drop them or keep their shape"
        yield hair.fault("points", message)
    elif alike.any():
        message = f"points of strand {np.argmax(alike)} lie on each other; {alike.sum()} such strands"
        yield hair.fault("points", f"{message}, which have no direction there")


def _short(hair: Snapshot) -> np.ndarray:
    return hair.lengths <= COLLAPSED * np.median(hair.lengths)


def _coincident(hair: Snapshot) -> np.ndarray:
    """Return which strands have two coincident consecutive points, (c,), except doubled ends."""
    mean = np.repeat(hair.lengths / (hair.counts - 1), hair.counts - 1)
    alike = hair.segments < COINCIDENT * mean
    if UsdGeom.BasisCurves(hair.prim).GetWrapAttr().Get() != UsdGeom.Tokens.pinned:
        firsts = hair.roots - np.arange(len(hair.counts))
        alike[firsts] = alike[firsts + hair.counts - 2] = False
    return hair.per_strand(np.logical_or, alike)


def spikes(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find strands with one segment far longer than all others."""
    longest = hair.per_strand(np.maximum, hair.segments)
    others = (hair.lengths - longest) / np.maximum(hair.counts - 2, 1)
    spiked = (hair.counts > LEAST) & (longest > SPIKE * others) & ~_short(hair)
    if spiked.mean() > SOME or (spiked & (longest > ALONE * others)).any():
        message = f"strand {np.argmax(spiked)} has a segment {SPIKE:g} times as long as its others"
        yield hair.fault("points", f"{message}; {spiked.sum()} such strands")


def zigzags(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find strands whose points alternate from side to side, or forwards and backwards.

    The direction changes at four points in a row, every time nearly opposite to the change before. The changes of a
    helix with n points a turn are 360 / n degrees apart: with 2.7 and more it has no zigzags.
    """
    if hair.counts.max() < ALTERNATING + 3:
        return
    edges = np.diff(hair.points.astype(np.float64), axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    turns = np.diff(edges, axis=0)
    sizes = np.linalg.norm(turns, axis=1)
    sharp = sizes > BEND * np.minimum(lengths[:-1], lengths[1:])
    opposite = (turns[:-1] * turns[1:]).sum(axis=1) < OPPOSITE * sizes[:-1] * sizes[1:]
    swings = opposite & sharp[:-1] & sharp[1:]  # of the points i to i + 3
    rows = np.logical_and.reduce([swings[k : len(swings) + 1 + k - ALTERNATING] for k in range(ALTERNATING)])
    owners = np.repeat(np.arange(len(hair.counts)), hair.counts)
    begins = np.flatnonzero(rows)
    whole = owners[begins] == owners[begins + ALTERNATING + 2]
    found = np.unique(owners[begins[whole]])
    if len(found) > SOME * len(hair.counts):
        message = f"of strand {found[0]} alternate from side to side; {len(found)} such strands"
        yield hair.fault("points", f"{message}; points are in order, curls have 3 or more a turn")


def stretch(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find strands whose length changes."""
    before = track.reference
    if before is None or not np.array_equal(hair.counts, before.counts):
        return
    kept = ~(_short(hair) | _coincident(hair) | _short(track.first))
    ratio = float(np.median((hair.lengths / np.maximum(before.lengths, TINY))[kept])) if kept.any() else 1.0
    if not STRETCH[0] <= ratio <= STRETCH[1]:
        yield hair.fault("points", f"make strands {ratio:.3g} times as long as they were")
        return
    parts = hair.segments / np.maximum(before.segments, TINY)
    minded = before.segments > SHORT * np.median(before.segments)
    torn = kept & hair.per_strand(np.logical_or, minded & ((parts < TORN[0]) | (parts > TORN[1])))
    apart = kept & hair.per_strand(np.logical_or, minded & (parts > APART))
    if torn.mean() > SOME or apart.any():
        torn = torn if torn.mean() > SOME else apart
        worst = hair.per_strand(np.maximum, np.where(minded, parts, 0))[np.argmax(torn)]
        message = f"stretch a segment of strand {np.argmax(torn)} to {worst:.2g} times its length"
        yield hair.fault("points", f"{message}; {torn.sum()} such strands")


def widths_steady(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find widths that change in time, so that hair flickers."""
    before = track.first.array("widths")
    now = hair.array("widths")
    if before is None or now is None or len(before) != len(now) or not len(now):
        return
    thick = before > 0
    changed = thick & ((now > OTHER[1] * before) | (now < OTHER[0] * before))
    if changed.sum() > SOME * len(now):
        k = int(np.argmax(changed))
        message = f"element {k} is {now[k]:.3g} and was {before[k]:.3g}"
        yield hair.fault("widths", f"{message}; {changed.sum()} such, hair keeps its width")


def rounded(track: Track, hair: Snapshot) -> Iterator[Fault]:
    """Find rounded points: moving hair is not on a lattice."""
    if not track.moves or hair.code != track.points[-1]:
        return
    steps = [_lattice(hair.points[:, axis]) for axis in range(3)]
    if min(steps) > ROUGH * np.median(hair.segments):
        message = f"lie on a lattice of {min(steps):.2g}, {np.median(hair.segments) / min(steps):.2g} steps a segment"
        yield hair.fault("points", f"{message}; single precision is right")


def _lattice(values: np.ndarray) -> float:
    """Return the step of which all values are multiples, 0 for none or a negligible one."""
    places = np.unique(values.astype(np.float64))
    step = float(np.diff(places).min()) if len(places) > FEW else 0.0
    if not step:
        return 0.0
    step = np.ptp(places) / np.round(np.ptp(places) / step)  # what single precision has made of the least is inexact
    off = (places - places[0]) / step
    return float(step) if np.abs(off - np.round(off)).max() < ON_LATTICE else 0.0


def rest(scene: Scene, track: Track) -> Iterator[Fault]:
    """Find a rest pose in another unit than the hair, or of other strands."""
    if track.still is None or not np.median(track.first.lengths):
        rested = track.has("primvars:pref", "primvars:Pref", "primvars:rest")
        if track.has("primvars:skinprim", "primvars:skinprimuv") and not rested:
            yield track.fault("primvars:pref", "has no value; hair that is bound to a skin needs its rest pose")
        return
    first, still = track.first, track.still
    here, there, tips = first.points[first.roots], still.points[still.roots], still.points[still.tips]
    roots = scene.authored_roots(track)
    stands = roots is None or np.median(roots.misses(track.first, track.first.code)) <= roots.reach
    ratio = float(np.median(track.growth))
    apart = ((track.growth < OTHER[0]) | (track.growth > OTHER[1])) & ~_short(track.first)
    if not REST[0] <= ratio <= REST[1]:
        message = f"has strands {ratio:.3g} times as long as points has; it is in the unit of the points"
        yield track.fault("primvars:pref", message)
    elif apart.mean() > SOME:
        message = f"strand {np.argmax(apart)} is {track.growth[np.argmax(apart)]:.2g} times as long as in points"
        yield track.fault("primvars:pref", f"{message}; {apart.sum()} such strands, are they others?")
    elif len(here) >= FEW and _unlike(here, tips) < _unlike(here, there) / MUCH:
        yield track.fault("primvars:pref", "has its tips where points has its roots; the root comes first")
    elif len(here) >= FEW and stands and _unlike(here, there * MIRROR) < _unlike(here, there) / MUCH:
        yield track.fault("primvars:pref", "is a mirror image of points; mirror it back")
    elif (others := _scrambled(first, still)) > OTHERS:
        message = f"{others:.0%} of strands have other neighbours there than in points: they belong to other strands"
        yield track.fault("primvars:pref", message)


def _scrambled(hair: Snapshot, still: Snapshot) -> float:
    """Return the share of strands whose nearest neighbour at the root is far at rest: those in another order."""
    if len(hair.counts) < FEW:
        return 0.0
    some = np.unique(np.linspace(0, len(hair.counts) - 1, MANY).astype(np.int64))
    roots = hair.points[hair.roots[some]].astype(np.float64)
    rests = still.points[still.roots[some]].astype(np.float64)
    apart = np.linalg.norm(roots[:, None] - roots, axis=2)
    np.fill_diagonal(apart, np.inf)
    nearest = apart.argmin(axis=1)
    now = apart[np.arange(len(some)), nearest]
    then = np.linalg.norm(rests - rests[nearest], axis=1)
    return float((then > PARTED * now + ROUGH * np.ptp(rests, axis=0).max()).mean())


def _unlike(these: np.ndarray, those: np.ndarray) -> float:
    """Return the distance of two ordered sets of places after the best rigid alignment (Kabsch)."""
    a, b = (places.astype(np.float64) - places.mean(axis=0, dtype=np.float64) for places in (these, those))
    left, _, right = np.linalg.svd(a.T @ b)
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return float(np.sqrt(((a @ turn - b) ** 2).sum(axis=1).mean()))
