"""Strands made elsewhere become a groom: thinned, cut into equal segments, bound to the body.

The shape of a file, points or rest points, is that whose roots lie on the body. Strands of reconstructions are turned
root first, and moved or cut where they are inside the body.
"""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Literal

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.collider import probe_union
from hairpipe.geometry.rotations import root_frames
from hairpipe.geometry.triangle_tree import nearest_sites, project, tree_over
from hairpipe.groom.binding import bind_roots, bind_tips
from hairpipe.groom.resampling import ROUNDING, Cut, equal_segments
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import ColliderField, build_collider_field
from hairpipe.levelset.sample import Interpolation
from hairpipe.values import Body, Groom, Mesh
from hairpipe.values.groom import Curves, strand_lengths, unequal
from hairpipe.values.painting import maps_at
from hairpipe.values.strand_arrays import name_strands, offsets_of, points_of_strands, rows_of, take, take_strands
from hairpipe.values.triangles import Sites, site_uv


def placed(mesh: Mesh, curves: Curves) -> Curves:
    """Return the curves as they grow from a mesh, without a rest shape or spare points; pure.

    The rest shape is used if its roots lie at least as near to the skin as those of the points: hair and body of a
    file may be of different times. Curves are used with pinned ends if these lie nearer to the skin: B-splines of hair
    whose first control vertex is the root, as written by Blender, would otherwise begin off the skin. Distances are
    compared by their median over the strands.
    """
    tree = tree_over(mesh.points[mesh.triangles])
    rest = curves.points if curves.rest is None else curves.rest
    shapes = [(shape, spare) for spare in (curves.spare, 0 * curves.spare) for shape in (rest, curves.points)]
    distances = []
    for shape, spare in shapes:
        roots = shape[curves.offsets[:-1] + spare]
        finite = np.isfinite(roots).all(axis=1)
        distances.append(np.median(project(tree, roots[finite])[1]) if finite.any() else np.inf)
    shape, spare = shapes[int(np.argmin(distances))]
    first = curves.offsets[:-1] + spare
    counts = curves.offsets[1:] - spare - first
    shaped = replace(curves, points=shape, rest=None, spare=np.zeros_like(curves.spare))
    return take(shaped, np.arange(len(counts)), rows_of(first, counts), counts)


Inside = Literal["keep", "push", "cut"]
SAMPLES, FINEST, COARSEST = 200, 0.5e-3, 4e-3
"""Samples of the level set along the largest side of the body, and limits of their spacing [m]."""
DEPTH = 0.2e-3
"""Depth under the skin that counts as inside [m]: roots on triangles between curved samples are no deeper."""
PUSHES, HALVINGS = 4, 24
BAND = 4.0  # half width of the level set, in samples; the inside is sampled coarsely beyond


def rooted(mesh: Mesh, curves: Curves, reach: float) -> Curves:
    """Return the strands whose nearer end is within reach [m] of a body, from this end on; warn of the others. Pure."""
    ends = curves.offsets[:-1], curves.offsets[1:] - 1
    first, last = (nearest_sites(mesh, curves.points[end])[1] for end in ends)
    turned = last < first
    found = np.minimum(first, last) <= reach
    strands = np.flatnonzero(found)
    if not len(strands):
        right = f"one end within reach = {reach:g} m of the body"
        raise BadInput("no strand begins or ends at the body", right=right)
    if not found.all():
        gone = curves.ids[~found]
        message = f"{len(gone)} strands are left out, as neither end is within reach = {reach:g} m of the body"
        warnings.warn(f"{message}: {name_strands(gone)}", stacklevel=3)
    if turned[found].any():
        warnings.warn(
            f"{turned[found].sum()} of {found.sum()} strands are turned: their last point is the root", stacklevel=3
        )
    counts = np.diff(curves.offsets)
    rows = np.arange(len(curves.points))
    back = np.repeat(curves.offsets[:-1] + curves.offsets[1:] - 1, counts) - rows
    rows = np.where(np.repeat(turned, counts), back, rows)
    return take(curves, strands, rows[np.repeat(found, counts)], counts[strands])


def freed(mesh: Mesh, curves: Curves, inside: Inside) -> Curves:
    """Return the strands outside of a body: what is inside before the first point outside is cut off; pure.

    inside  later points inside are pushed out to the nearest place of the skin, or the strand is cut before them
    """
    side = float(np.ptp(mesh.points, axis=0).max())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # holes and thin parts: `bake_levelset` of the shot reports them
        level = bake(mesh, float(np.clip(side / SAMPLES, FINEST, COARSEST)), BAND)
    body = build_collider_field(level, level, 1.0, Interpolation.linear)
    points = curves.points.copy()
    deep = probe_union([body], points).distance < -DEPTH
    starts = curves.offsets[:-1].astype(np.int64)
    ends = curves.offsets[1:].astype(np.int64)
    outside = np.where(deep, len(points), np.arange(len(points)))
    first = np.minimum.reduceat(outside, starts)
    kept = first < ends
    buried = kept & (first > starts)
    at = first[buried]
    begins = np.where(buried, first - 1, starts)
    points[at - 1] = crossings(body, points[at - 1], points[at])  # a root on the skin
    deep[at - 1] = False
    later = deep & (np.arange(len(points)) > np.repeat(first, ends - starts)) & np.repeat(kept, ends - starts)
    touched = np.add.reduceat(later, starts) > 0
    if inside == "push":
        for _ in range(PUSHES):
            skin = probe_union([body], points[later])
            points[later] -= np.minimum(skin.distance, 0.0)[:, None] * skin.normal
        lasts = ends
    else:
        reached = np.minimum.reduceat(np.where(later, np.arange(len(points)), len(points)), starts)
        lasts = np.minimum(ends, reached)
        kept &= lasts - begins > 1
    whole = np.flatnonzero(kept)
    if not len(whole):
        raise BadInput("all strands are inside the body", right="strands outside, in the unit of the body")
    if not kept.all():
        warnings.warn(
            f"{(~kept).sum()} strands are left out, inside the body: {name_strands(curves.ids[~kept])}", stacklevel=3
        )
    if buried.any():
        warnings.warn(f"{buried.sum()} strands are cut where they leave the body, which is their root", stacklevel=3)
    if touched.any():
        what = f"{later.sum()} points of {touched.sum()} strands are inside the body"
        done = "are pushed out" if inside == "push" else "end the strands"
        warnings.warn(f"{what} and {done}", stacklevel=3)
    counts = (lasts - begins)[whole]
    return take(replace(curves, points=points), whole, rows_of(begins[whole], counts), counts)


def crossings(body: ColliderField, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """Return where segments leave a body, from places inside to places outside, (n, 3) [m] each, by bisection."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        within = (probe_union([body], middle).distance < 0.0)[:, None]
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    return outside


Tips = Literal["file", "free", "held"]
EQUAL = 1e-6  # difference of segments that counts as rounding [m]: coordinates of files are in single precision
KEPT = 0.9  # of the length of a strand, without a word: what four segments keep of a circle


def adopt(
    body: Body,
    curves: Curves,
    *,
    cut: Cut | None,
    strands: int | None,
    reach: float,
    tips: Tips = "file",
    nearer_end: bool = False,
    inside: Inside = "keep",
) -> Groom:
    """Return strands of a file as a groom.

    curves      curves on the body at rest, in the shape whose roots lie nearest to the skin
    cut         division into segments; by default the number of segments in the file. None: the points of the file
    strands     number of strands to keep, evenly spread over their order; None: all
    reach       maximum distance of a root from the body [m]
    tips        held by the body, free, or as in the file
    nearer_end  whether the end nearer to the body is the root; otherwise the first point is
    inside      what becomes of points inside the body, see `freed`
    Raises BadInput naming strands whose roots are too far from the body, with the cause; warns of coincident roots, of
    strands with too few segments, of strands that are omitted (non-finite or too short), and of distant tips.
    """
    shape = placed(body.mesh, take(curves, choose_strands(len(curves.ids), strands)))
    if tips != "file":
        shape = replace(shape, held=np.full(len(shape.held), tips == "held"))
    if len(shape.ids) == 0:
        raise BadInput("there are no strands", right="at least one")
    strand = np.repeat(np.arange(len(shape.ids)), np.diff(shape.offsets))
    finite = np.bincount(strand, ~np.isfinite(shape.points).all(axis=1), len(shape.ids)) == 0.0
    broken = shape.ids[~finite]
    if not finite.any():
        raise BadInput(f"{name_strands(broken)} have points that are not finite", right="finite coordinates")
    if len(broken):
        message = f"{len(broken)} strands are left out, with points that are not finite: {name_strands(broken)}"
        warnings.warn(message, stacklevel=2)
    shape = take(shape, np.flatnonzero(finite))
    with report_times(body, curves):
        shape = rooted(body.mesh, shape, reach) if nearer_end else shape
        shape = shape if inside == "keep" else freed(body.mesh, shape, inside)
        roots = shape.points[shape.offsets[:-1]]
        ends = shape.points[shape.offsets[1:] - 1]
        bound = bind_roots(body.mesh, roots, ends, reach, shape.ids)
    shortest = ROUNDING if cut is None else cut.shortest
    long = drop_short(shape.points, shape.offsets, shape.ids, shortest)
    shape = take(shape, long)
    points, offsets = shape.points, shape.offsets
    if cut is not None:
        points, offsets = cut_up(points, offsets, shape.ids, cut)
    kept = drop_short(points, offsets, shape.ids, shortest)
    points, offsets = take_strands(points, offsets, kept)
    sites = Sites(*(array[long[kept]] for array in bound))
    shape = take(shape, kept)
    shared = len(kept) - len(np.unique(points[offsets[:-1]], axis=0))
    if shared:
        warnings.warn(f"{shared} strands share their root with another strand", stacklevel=2)
    frames = root_frames(body.mesh.points, body.mesh.triangles, *sites)
    uv = site_uv(body.mesh, sites) if shape.root_uv is None else shape.root_uv
    marks = {name: getattr(shape, name) for name in ("groups", "group_names", "guides")}
    along = ((name, getattr(shape, name)) for name in ("widths", "colours"))
    marks |= {name: spread_along(values, shape, points, offsets) for name, values in along if values is not None}
    maps = maps_at(body, sites) | shape.maps
    groom = Groom(points, offsets, shape.ids, *sites, frames, uv, maps=maps, **marks)
    return bind_tips(body.mesh, groom, shape.held, reach)


def selected(curves: Curves, select: Literal["all", "guides", "hair"]) -> Curves:
    """Return all curves, the guides, or the others; pure.

    Raises BadInput if there are none.
    """
    if select == "all":
        return curves
    guides = np.zeros(len(curves.ids), bool) if curves.guides is None else curves.guides
    chosen = np.flatnonzero(guides == (select == "guides"))
    if not len(chosen):
        what = "no curve is a guide" if select == "guides" else "all curves are guides"
        raise BadInput(what, right='purpose guide or groom_guide in the file, or select = "all"')
    return take(curves, chosen)


def spread_along(values: np.ndarray, shape: Curves, points: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Return values at the points of a shape at those of its resegmented strands, by length; pure."""
    along = []
    for strand in range(len(offsets) - 1):
        rows = slice(shape.offsets[strand], shape.offsets[strand + 1])
        curves = shape.points[rows], points[offsets[strand] : offsets[strand + 1]]
        steps = (np.linalg.norm(np.diff(curve, axis=0), axis=1) for curve in curves)
        way, here = (np.concatenate([[0.0], np.cumsum(lengths)]) for lengths in steps)
        columns = values[rows].reshape(len(way), -1).T
        along.append(np.stack([np.interp(here * (way[-1] / here[-1]), way, column) for column in columns], axis=1))
    return np.concatenate(along).reshape(-1, *values.shape[1:]).astype(values.dtype)


def choose_strands(total: int, wanted: int | None) -> np.ndarray:
    """Return which of total strands to keep, evenly spread, (S,) int32."""
    kept = total if wanted is None else min(wanted, total)
    return (np.arange(kept, dtype=np.int64) * total // max(kept, 1)).astype(np.int32)


@contextmanager
def report_times(body: Body, curves: Curves) -> Iterator[None]:
    """State in a BadInput of this block at which times body and hair were read, where these differ."""
    try:
        yield
    except BadInput as fault:
        if body.time == curves.time or curves.time is None:
            raise
        when = "at rest" if body.time is None else f"at time code {body.time:g}"
        what = f"{fault.what}; the body is read {when}, the moving hair at time code {curves.time:g}"
        raise BadInput(what, where=fault.where, right=f"{fault.right}, at one time_code") from None


def drop_short(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray, shortest: float) -> np.ndarray:
    """Return the strands no shorter than a segment [m], (n,), and warn of the others; BadInput where none is."""
    strand = np.repeat(np.arange(len(ids)), np.diff(offsets))
    pieces = np.linalg.norm(np.diff(points, axis=0), axis=1) * (strand[1:] == strand[:-1])
    lengths = np.bincount(strand[1:], pieces, len(ids))  # also of strands of one point
    long = lengths >= shortest * (1.0 - ROUNDING)
    short = ids[~long]
    if len(short):
        message = f"{len(short)} strands are left out, shorter than shortest = {shortest:g} m: {name_strands(short)}"
        warnings.warn(message, stacklevel=3)
    if not long.any():
        raise BadInput(f"all strands are shorter than shortest = {shortest:g} m", right="longer ones; look at the unit")
    return np.flatnonzero(long)


def cut_up(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray, cut: Cut) -> tuple[np.ndarray, np.ndarray]:
    """Return points and offsets of resegmented strands; only a single segment may be shorter than the minimum.

    Chords cut through curls: the number of segments is reduced by the remaining length until none is too short. Strands
    whose segments are equal, up to the rounding of files, are unchanged.
    """
    lengths = strand_lengths(points, offsets)
    counts = wanted = cut.wanted(lengths, np.diff(offsets) - 1)
    most = np.maximum(cut.bearable(lengths), 1)
    while True:
        counts = np.minimum(counts, most)
        new = offsets_of(counts + 1)
        made = equal_segments(points, offsets, new)
        most = np.maximum(cut.bearable(strand_lengths(made, new)), 1)
        if (counts <= most).all():
            break
    same = counts == np.diff(offsets) - 1
    same &= unequal(points, offsets) <= EQUAL
    made[points_of_strands(np.flatnonzero(same), new)] = points[points_of_strands(np.flatnonzero(same), offsets)]
    warn_of_fewer(ids[counts < wanted], cut.shortest)
    warn_of_ironing(points, offsets, made, new)
    return made, new


def warn_of_ironing(given: np.ndarray, offsets: np.ndarray, points: np.ndarray, cut: np.ndarray) -> None:
    """Warn where segments are too few for curls and clearly shorter than the strand given, naming how many would do."""
    lengths = KEPT * strand_lengths(given, offsets)
    short = np.flatnonzero(strand_lengths(points, cut) < lengths)
    count = len(short)
    needed = int(np.diff(cut)[short].max(initial=0)) - 1
    while len(short):
        needed += needed // 4 + 1
        curves = take_strands(given, offsets, short)
        new = offsets_of(np.full(len(short), needed + 1))
        short = short[strand_lengths(equal_segments(*curves, new), new) < lengths[short]]
    if count:
        lost = f"{count} strands become more than {1.0 - KEPT:.0%} shorter, as their segments cut through curls"
        warnings.warn(f"{lost}; segments = {needed} avoids this", stacklevel=3)


def warn_of_fewer(ids: np.ndarray, shortest: float) -> None:
    """Warn that strands of these ids have fewer segments than asked for."""
    if len(ids):
        why = f"so that none is shorter than shortest = {shortest:g} m"
        warnings.warn(f"{len(ids)} strands are cut into fewer segments, {why}: {name_strands(ids)}", stacklevel=3)
