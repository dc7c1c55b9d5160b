"""Some strands of a groom: every n-th, groups, or patches of neighbours, which hair that touches needs; joined grooms.

Members of an ensemble of grooms differ imperceptibly: they separate chaos from bias.
"""

from dataclasses import fields, replace

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.sorting import morton_order
from hairpipe.groom.binding import TIPS
from hairpipe.values import Ends, Groom
from hairpipe.values.groom import labels_of, numbered
from hairpipe.values.random_streams import GOLDEN, stream
from hairpipe.values.strand_arrays import FREE, name_strands, offsets_of, shares_of, take


def sample_patches(groom: Groom, strands: int, patches: int, number: int) -> Groom:
    """Return patches of a groom of equal size, concatenated, with the order and ids of their strands; pure.

    A patch is a seed and the roots nearest to it; seeds are spread evenly along a curve through all roots. The number
    of strands is rounded up to a multiple of the patches; a groom with at most this many is unchanged. Samples of
    different numbers share no strand. Raises BadInput if the groom has too few strands for that many samples.
    """
    total = len(groom.ids)
    size = -(-strands // patches)
    if number == 0 and total <= size * patches:
        return groom
    if total < size * patches * (number + 1):
        raise BadInput(
            f"{total} strands are too few for {number + 1} samples of {size * patches}", where="groom", right="fewer"
        )
    return take(groom, choose_patches(groom.points[groom.offsets[:-1]], size, patches, number).ravel())


def choose_patches(roots: np.ndarray, size: int, patches: int, number: int) -> np.ndarray:
    """Return which of the roots [m], (S, 3), are in each patch of a sample, ascending, (patches, size) int64."""
    order = morton_order(roots)
    free = np.ones(len(roots), bool)
    chosen = np.empty((patches, size), np.int64)
    for sample in range(number + 1):
        shift = (0.5 + sample * GOLDEN) % 1.0
        for patch in range(patches):
            seed = roots[order[int((patch + shift) / patches * len(roots))]]
            distances = np.where(free, np.sum((roots - seed) ** 2, axis=1), np.inf)
            chosen[patch] = np.sort(np.argsort(distances, kind="stable")[:size])
            free[chosen[patch]] = False
    return chosen


def thinned(groom: Groom, every: int) -> Groom:
    """Return every n-th strand of a groom, with its id; pure.

    Strands are ordered along a Morton curve through their roots, so the result is about as even as the groom.
    """
    return take(groom, np.arange(every // 2, len(groom.ids), every))


def perturbed(groom: Groom, member: int, tip: float) -> Groom:
    """Return a member of the ensemble around a groom: every strand is rotated rigidly about its root; pure.

    member  0 is the groom itself
    tip     standard deviation of each component of the tip's target [m]: the distance of root and tip is unchanged, so
            that the tip moves by this in both directions normal to the line between them

    A rotation depends on the id of the strand and the member alone. Raises BadInput for held tips.
    """
    if member == 0:
        return groom
    if groom.tip_triangles is not None and (groom.tip_triangles >= 0).any():
        held = name_strands(groom.ids[groom.tip_triangles >= 0])
        raise BadInput(f"the tip is held of {held}", where="groom", right="strands held at the root alone")
    roots = groom.points[groom.offsets[:-1]]
    lines = groom.points[groom.offsets[1:] - 1] - roots
    aims = lines + [tip * stream(member, f"perturb/{strand}").standard_normal(3) for strand in groom.ids]
    here, there = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True) for vectors in (lines, aims))
    axes = np.cross(here, there)
    cosines = np.sum(here * there, axis=1)
    strands, _ = shares_of(groom.offsets)
    axes = axes[strands]
    cosines = cosines[strands, None]
    arms = groom.points - roots[strands]
    # Rodrigues, with the sine in the axis: the turn of v is v + a x v + a x (a x v) / (1 + cos).
    across = np.cross(axes, arms)
    return replace(groom, points=groom.points + (across + np.cross(axes, across) / (1.0 + cosines)))


def joined_strands(grooms: tuple[Groom, ...], groups: tuple[str, ...] = ()) -> Groom:
    """Return the strands of all grooms in turn, renumbered, each groom as a group of this name; pure.

    Roots keep their triangles, so all grooms have to be on the same body. Tips are free in grooms without tip data,
    and widths, colours, guides and maps are kept if all grooms have them. Groups of equal names are one.
    Without names the groups of the grooms are kept. Raises BadInput for another number of names than of grooms.
    """
    if groups and len(groups) != len(grooms):
        raise BadInput(f"{len(groups)} names for {len(grooms)} grooms", where="groups", right="a name for each groom")
    kept = {
        name: np.concatenate([getattr(groom, name) for groom in grooms])
        for name in ("points", "root_triangles", "root_barycentrics", "root_frames", "root_uv")
    }
    if any(groom.tip_triangles is not None for groom in grooms):
        tips = [tips_of(groom) for groom in grooms]
        kept |= {name: np.concatenate([tip[name] for tip in tips]) for name in TIPS}
    for name in ("widths", "colours", "guides"):
        values = [value for groom in grooms if (value := getattr(groom, name)) is not None]
        if len(values) == len(grooms):
            kept[name] = np.concatenate(values)
    names: tuple[str, ...] = ()
    if groups:
        counts = [len(groom.ids) for groom in grooms]
        kept["groups"], names = numbered(np.repeat(groups, counts))
    elif any(groom.groups is not None for groom in grooms):
        labels = [  # A groom without groups is one of its own.
            np.full(len(groom.ids), f"groom{i}") if groom.groups is None else labels_of(groom.groups, groom.group_names)
            for i, groom in enumerate(grooms)
        ]
        kept["groups"], names = numbered(np.concatenate(labels))
    shared = set.intersection(*(set(groom.maps) for groom in grooms))
    maps = {name: np.concatenate([groom.maps[name] for groom in grooms]) for name in sorted(shared)}
    counts = np.concatenate([np.diff(groom.offsets) for groom in grooms])
    ids = np.arange(len(counts), dtype=np.int32)
    return Groom(offsets=offsets_of(counts), ids=ids, group_names=names, maps=maps, **kept)


def tips_of(groom: Groom) -> dict[str, np.ndarray]:
    """Return the fields of the tips; those of a groom without any are free."""
    if groom.tip_triangles is not None:
        return {name: getattr(groom, name) for name in TIPS}
    count = len(groom.ids)
    free = np.full(count, FREE, np.int32), np.zeros((count, 3)), np.tile(np.eye(3, 4), (count, 1, 1))
    return dict(zip(TIPS, free, strict=True))


def joined_ends(ends: tuple[Ends, ...]) -> Ends:
    """Return the ends of all strands in turn; pure."""
    return Ends(*(np.concatenate([getattr(part, field.name) for part in ends]) for field in fields(Ends)))
