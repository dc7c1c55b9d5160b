"""Strands of reconstructions on a body: turned root first, and moved or cut where they are inside it."""

import warnings
from dataclasses import replace
from typing import Literal

import numpy as np

from hairpipe.data import Mesh
from hairpipe.data.curves import Curves
from hairpipe.errors import BadInput
from hairpipe.groom.binding import name_strands, nearest_sites
from hairpipe.groom.strand_arrays import offsets_of, points_of_strands
from hairpipe.levelset.bake.whole import bake
from hairpipe.levelset.collider import SdfSample
from hairpipe.levelset.collider_field import ColliderField, build_collider_field
from hairpipe.levelset.interpolation import Interpolation

Inside = Literal["keep", "push", "cut"]
SAMPLES, FINEST, COARSEST = 200, 0.5e-3, 4e-3
"""Samples of the level set along the largest side of the body, and limits of their spacing [m]."""
DEPTH = 0.2e-3
"""Depth under the skin that counts as inside [m]: roots on triangles between curved samples are no deeper."""
PUSHES, HALVINGS = 4, 24
BAND = 4.0  # half width of the level set, in samples; the inside is sampled coarsely beyond


def taken(
    curves: Curves, strands: np.ndarray, rows: np.ndarray | None = None, counts: np.ndarray | None = None
) -> Curves:
    """Return some of the curves, in the order in which they are named; pure.

    rows, counts  their points, strand after strand, and the number of points of each; by default all they have
    """
    rows = points_of_strands(strands, curves.offsets) if rows is None else rows
    counts = np.diff(curves.offsets)[strands] if counts is None else counts
    per_point = {name: rows for name in ("points", "rest", "widths", "colours")}
    per_strand = {name: strands for name in ("ids", "held", "spare", "root_uv", "groups", "guides")}
    found = {name: (getattr(curves, name), kept) for name, kept in (per_point | per_strand).items()}
    fields = {n: None if values is None else np.ascontiguousarray(values[kept]) for n, (values, kept) in found.items()}
    maps = {name: values[strands] for name, values in curves.maps.items()}
    return replace(curves, offsets=offsets_of(counts), maps=maps, **fields)


def rooted(mesh: Mesh, curves: Curves, reach: float) -> Curves:
    """Return the strands whose nearer end is within reach [m] of a body, from this end on; pure.

    Warns of the numbers of strands that are turned, and of those left out, by their ids; raises BadInput if none is
    left.
    """
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
    return taken(curves, strands, rows[np.repeat(found, counts)], counts[strands])


def freed(mesh: Mesh, curves: Curves, inside: Inside) -> Curves:
    """Return the strands outside of a body: what is inside before the first point outside is cut off; pure.

    inside  later points inside are pushed out to the nearest place of the skin, or the strand is cut before them

    Warns of the numbers of strands and points that are changed, and of strands that are left out since they are inside
    as a whole. Raises BadInput if none is left, or where the body encloses nothing.
    """
    side = float(np.ptp(mesh.points, axis=0).max())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # holes and thin parts: `bake_levelset` of the shot reports them
        level = bake(mesh, float(np.clip(side / SAMPLES, FINEST, COARSEST)), BAND)
    body = build_collider_field(level, level, 1.0, Interpolation.linear)
    points = curves.points.copy()
    deep = _sampled(body, points).distance < -DEPTH
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
        points = pushed(body, points, later)
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
    rows = np.arange(counts.sum()) + np.repeat(begins[whole] - (np.cumsum(counts) - counts), counts)
    return taken(replace(curves, points=points), whole, rows, counts)


def crossings(body: ColliderField, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """Return where segments leave a body, from places inside to places outside, (n, 3) [m] each, by bisection; pure."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        within = (_sampled(body, middle).distance < 0.0)[:, None]
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    return outside


def pushed(body: ColliderField, points: np.ndarray, deep: np.ndarray) -> np.ndarray:
    """Return points [m], (P, 3), of which some, (P,) bool, are moved along the normal out of a body; pure."""
    points = points.copy()
    for _ in range(PUSHES):
        found = _sampled(body, points[deep])
        points[deep] -= np.minimum(found.distance, 0.0)[:, None] * found.normal
    return points


def _sampled(body: ColliderField, points: np.ndarray) -> SdfSample:
    found = SdfSample.blank(len(points))
    body.probe(np.ascontiguousarray(points), 0.0, found)
    return found
