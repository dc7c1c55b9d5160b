"""Several grooms as one."""

from dataclasses import fields

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.groom.binding import FREE, TIPS
from hairpipe.groom.strand_arrays import offsets_of
from hairpipe.values import Ends, Groom
from hairpipe.values.groom import labels_of, numbered


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
