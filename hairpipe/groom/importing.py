"""Strands made elsewhere become a groom: thinned, cut into equal segments, bound to the body."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Literal

import numpy as np

from hairpipe.data import Body, Groom
from hairpipe.data.curves import Curves
from hairpipe.data.lengths import strand_lengths
from hairpipe.errors import BadInput
from hairpipe.groom.binding import bind_roots, bind_tips, name_strands, root_frames
from hairpipe.groom.cutting import ROUNDING, Cut
from hairpipe.groom.placing import placed
from hairpipe.groom.resampling import equal_segments
from hairpipe.groom.strand_arrays import offsets_of, take_strands
from hairpipe.spatial.triangles import Sites, site_uv

Tips = Literal["file", "free", "held"]
KEPT = 0.9  # of the length of a strand, without a word: what four segments keep of a circle


def adopt(body: Body, curves: Curves, *, cut: Cut, strands: int | None, reach: float, tips: Tips = "file") -> Groom:
    """Return strands of a file as a groom.

    curves   curves on the body at rest, in the shape whose roots lie nearest to the skin
    cut      division into segments; by default the number of segments in the file
    strands  number of strands to keep, evenly spread over their order; None: all
    reach    maximum distance of a root from the body [m]
    tips     held by the body, free, or as in the file
    Raises BadInput naming strands whose roots are too far from the body, with the cause; warns of coincident roots, of
    strands with too few segments, of strands that are omitted (non-finite or too short), and of distant tips.
    """
    chosen = choose_strands(len(curves.ids), strands)
    known = curves.ids[chosen]
    held = tips_held(tips, curves.held)[chosen]
    shape = placed(body.mesh, taken(curves, chosen))
    finite = drop_broken(shape.points, shape.offsets, known)
    known = known[finite]
    held = held[finite]
    shape = taken(shape, finite)
    points, offsets, widths = shape.points, shape.offsets, shape.widths
    with report_times(body, curves):
        bound = bind_roots(body.mesh, points[offsets[:-1]], points[offsets[1:] - 1], reach, known)
    long = drop_short(points, offsets, known, cut.shortest)
    given = (points, offsets)
    points, offsets = cut_up(*take_strands(points, offsets, long), known[long], cut)
    kept = drop_short(points, offsets, known[long], cut.shortest)
    points, offsets = take_strands(points, offsets, kept)
    kept = long[kept]
    warn_of_shared_roots(points[offsets[:-1]])
    sites = Sites(*(array[kept] for array in bound))
    frames = root_frames(body.mesh.points, body.mesh.triangles, *sites)
    groom = Groom(points, offsets, known[kept], *sites, frames, site_uv(body.mesh, sites))
    if widths is not None:
        groom = replace(groom, widths=spread_along(widths, *given, kept, offsets))
    return bind_tips(body.mesh, groom, held[kept], reach)


def tips_held(tips: Tips, held: np.ndarray) -> np.ndarray:
    """Return whether tips are held, (S,) bool: as the file has it, (S,), or all or none."""
    return held if tips == "file" else np.full(len(held), tips == "held")


def taken(curves: Curves, strands: np.ndarray) -> Curves:
    """Return some of the curves, in the order in which they are named; pure."""
    points, offsets = take_strands(curves.points, curves.offsets, strands)
    ids, held, spare = (array[strands] for array in (curves.ids, curves.held, curves.spare))
    rest, widths = (
        None if values is None else take_strands(values, curves.offsets, strands)[0]
        for values in (curves.rest, curves.widths)
    )
    return Curves(points, offsets, ids, held, spare, rest, widths, curves.time)


def spread_along(
    values: np.ndarray, points: np.ndarray, offsets: np.ndarray, strands: np.ndarray, new_offsets: np.ndarray
) -> np.ndarray:
    """Return values of points, (p,), at the points of resegmented strands, by their share of the length, (P,) float64.

    points, offsets  those of all strands
    strands          resegmented strands, with offsets new_offsets
    """
    along = []
    for strand, count in zip(strands, np.diff(new_offsets), strict=True):
        rows = slice(offsets[strand], offsets[strand + 1])
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[rows], axis=0), axis=1))])
        along.append(np.interp(np.linspace(0.0, way[-1], count), way, values[rows]))
    return np.concatenate(along)


def choose_strands(total: int, wanted: int | None) -> np.ndarray:
    """Return which of total strands to keep, evenly spread, (S,) int32."""
    kept = total if wanted is None else min(wanted, total)
    return (np.arange(kept, dtype=np.int64) * total // max(kept, 1)).astype(np.int32)


def drop_broken(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray) -> np.ndarray:
    """Return the strands with finite points, (n,) int64; warn of the others by their ids.

    Raise BadInput where none is.
    """
    if len(ids) == 0:
        raise BadInput("there are no strands", right="at least one")
    strand = np.repeat(np.arange(len(ids)), np.diff(offsets))
    broken = np.bincount(strand, ~np.isfinite(points).all(axis=1), len(ids)) > 0
    if broken.all():
        raise BadInput(f"{name_strands(ids)} have points that are not finite", right="finite coordinates")
    if broken.any():
        tips_held = f"{broken.sum()} strands are left out, with points that are not finite: {name_strands(ids[broken])}"
        warnings.warn(tips_held, stacklevel=3)
    return np.flatnonzero(~broken)


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
    """Return the strands at least as long as the shortest segment [m], (n,) int64; warn of the others by their ids.

    Raise BadInput where none is.
    """
    strand = np.repeat(np.arange(len(ids)), np.diff(offsets))
    pieces = np.linalg.norm(np.diff(points, axis=0), axis=1) * (strand[1:] == strand[:-1])
    lengths = np.bincount(strand[1:], pieces, len(ids))  # also of strands of one point
    long = lengths >= shortest * (1.0 - ROUNDING)
    warn_of_dropped(ids[~long], shortest)
    if not long.any():
        raise BadInput(f"all strands are shorter than shortest = {shortest:g} m", right="longer ones; look at the unit")
    return np.flatnonzero(long)


def cut_up(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray, cut: Cut) -> tuple[np.ndarray, np.ndarray]:
    """Return points and offsets of resegmented strands; only a single segment may be shorter than the minimum.

    Chords cut through curls: the number of segments is reduced by the remaining length until none is too short.
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


def warn_of_shared_roots(roots: np.ndarray) -> None:
    """Warn where several strands grow from one and the same point."""
    shared = len(roots) - len(np.unique(roots, axis=0))
    if shared:
        warnings.warn(f"{shared} strands share their root with another strand", stacklevel=3)


def warn_of_fewer(ids: np.ndarray, shortest: float) -> None:
    """Warn that strands of these ids have fewer segments than asked for."""
    if len(ids):
        why = f"so that none is shorter than shortest = {shortest:g} m"
        warnings.warn(f"{len(ids)} strands are cut into fewer segments, {why}: {name_strands(ids)}", stacklevel=3)


def warn_of_dropped(ids: np.ndarray, shortest: float) -> None:
    """Warn that strands of these ids are left out."""
    if len(ids):
        tips_held = f"{len(ids)} strands are left out, shorter than shortest = {shortest:g} m: {name_strands(ids)}"
        warnings.warn(tips_held, stacklevel=3)
