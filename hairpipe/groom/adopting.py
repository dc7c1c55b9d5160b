"""Strands made elsewhere become a groom: thinned, cut into equal segments, bound to the body."""

import warnings

import numpy as np

from hairpipe.body.surface import Sites, site_uv
from hairpipe.data import Body, Groom
from hairpipe.data.lengths import strand_lengths
from hairpipe.errors import BadInput
from hairpipe.groom.binding import bind_roots, name_strands, root_frames
from hairpipe.groom.cutting import ROUNDING, Cut
from hairpipe.groom.resampling import equal_segments

KEPT = 0.9  # of the length of a strand, without a word: what four segments keep of a circle


def adopt(body: Body, points: np.ndarray, offsets: np.ndarray, *, cut: Cut, strands: int | None, reach: float) -> Groom:
    """Return strands as a groom; their ids are their places in what was given.

    points   of all strands, root first [m], (p, 3) float64
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,) int32
    cut      of every strand; into as many segments as it has where nothing is said
    strands  how many to keep, evenly spread over their order; all where None
    reach    farthest a root may lie from the body [m]
    Raise BadInput naming strands that are no curves or whose roots are too far off; warn of roots in one place, of
    strands that segments are too few for, and of those that are too short for theirs, or for any.
    """
    known = choose_strands(len(offsets) - 1, strands)
    points, offsets = take_strands(points, offsets, known)
    refuse_points(points, offsets, known)
    bound = bind_roots(body.mesh, points[offsets[:-1]], reach, known)
    points, offsets, ids = drop_short(points, offsets, known, cut.shortest)
    points, offsets = cut_up(points, offsets, ids, cut)
    points, offsets, ids = drop_short(points, offsets, ids, cut.shortest)
    warn_of_shared_roots(points[offsets[:-1]])
    sites = Sites(*(array[np.isin(known, ids)] for array in bound))
    frames = root_frames(body.mesh.points, body.mesh.triangles, *sites)
    return Groom(points, offsets, ids, *sites, frames, site_uv(body.mesh, sites))


def choose_strands(total: int, wanted: int | None) -> np.ndarray:
    """Return which of total strands to keep, evenly spread, (S,) int32."""
    kept = total if wanted is None else min(wanted, total)
    return (np.arange(kept, dtype=np.int64) * total // max(kept, 1)).astype(np.int32)


def offsets_of(counts: np.ndarray) -> np.ndarray:
    """Return the offsets of strands with given numbers of points, (S+1,) int32."""
    return np.concatenate(([0], np.cumsum(counts))).astype(np.int32)


def take_strands(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the points and offsets of some of the strands."""
    kept = offsets_of(np.diff(offsets)[ids])
    shift = np.repeat(offsets[ids] - kept[:-1], np.diff(kept))
    return np.ascontiguousarray(points[np.arange(kept[-1]) + shift], dtype=np.float64), kept


def refuse_points(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray) -> None:
    """Raise BadInput where there are no strands, or some are not of finite points."""
    if len(ids) == 0:
        raise BadInput("there are no strands", right="at least one")
    strand = np.repeat(np.arange(len(ids)), np.diff(offsets))
    broken = np.bincount(strand, ~np.isfinite(points).all(axis=1), len(ids)) > 0
    if broken.any():
        raise BadInput(f"{name_strands(ids[broken])} have points that are not finite", right="finite coordinates")


def drop_short(
    points: np.ndarray, offsets: np.ndarray, ids: np.ndarray, shortest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, offsets and ids of strands as long as the shortest segment [m]; warn of the others by their ids.

    Raise BadInput where none is.
    """
    strand = np.repeat(np.arange(len(ids)), np.diff(offsets))
    pieces = np.linalg.norm(np.diff(points, axis=0), axis=1) * (strand[1:] == strand[:-1])
    lengths = np.bincount(strand[1:], pieces, len(ids))  # also of strands of one point
    long = lengths >= shortest * (1.0 - ROUNDING)
    if long.all():
        return points, offsets, ids
    warn_of_dropped(ids[~long], shortest)
    if not long.any():
        raise BadInput(f"all strands are shorter than shortest = {shortest:g} m", right="longer ones; look at the unit")
    return *take_strands(points, offsets, np.flatnonzero(long)), ids[long]


def cut_up(points: np.ndarray, offsets: np.ndarray, ids: np.ndarray, cut: Cut) -> tuple[np.ndarray, np.ndarray]:
    """Return points and offsets of strands cut anew, no segment shorter than it may be but where it is the only one.

    Chords cut through curls: what is left of the length tells how many segments it bears, until none is too short.
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
    count, needed = len(short), int(np.diff(cut)[short].max(initial=0)) - 1
    while len(short):
        needed += needed // 4 + 1
        curves, new = take_strands(given, offsets, short), offsets_of(np.full(len(short), needed + 1))
        short = short[strand_lengths(equal_segments(*curves, new), new) < lengths[short]]
    if count:
        lost = f"{count} strands lose more than {1.0 - KEPT:.0%} of their length to segments that cut through curls"
        warnings.warn(f"{lost}: with segments = {needed} none would", stacklevel=3)


def warn_of_shared_roots(roots: np.ndarray) -> None:
    """Warn where several strands grow from one and the same point."""
    shared = len(roots) - len(np.unique(roots, axis=0))
    if shared:
        warnings.warn(f"{shared} strands grow from a point from which another grows", stacklevel=3)


def warn_of_fewer(ids: np.ndarray, shortest: float) -> None:
    """Warn that strands of these ids have fewer segments than asked for."""
    if len(ids):
        why = f"so that none is shorter than shortest = {shortest:g} m"
        warnings.warn(f"{len(ids)} strands are cut into fewer segments, {why}: {name_strands(ids)}", stacklevel=3)


def warn_of_dropped(ids: np.ndarray, shortest: float) -> None:
    """Warn that strands of these ids are left out."""
    if len(ids):
        told = f"{len(ids)} strands are left out, shorter than shortest = {shortest:g} m: {name_strands(ids)}"
        warnings.warn(told, stacklevel=3)
