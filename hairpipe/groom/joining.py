"""Several grooms as one."""

from dataclasses import fields
from types import SimpleNamespace

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
        tips = [free_tips(len(groom.ids)) if groom.tip_triangles is None else groom for groom in grooms]
        kept |= {name: np.concatenate([getattr(of, name) for of in tips]) for name in TIPS}
    for name in ("widths", "colours", "guides"):
        values = [value for groom in grooms if (value := getattr(groom, name)) is not None]
        if len(values) == len(grooms):
            kept[name] = np.concatenate(values)
    names: tuple[str, ...] = ()
    if groups:
        counts = [len(groom.ids) for groom in grooms]
        kept["groups"], names = numbered(np.repeat(groups, counts))
    elif any(groom.groups is not None for groom in grooms):
        kept["groups"], names = joined_groups(grooms)
    shared = set.intersection(*(set(groom.maps) for groom in grooms))
    maps = {name: np.concatenate([groom.maps[name] for groom in grooms]) for name in sorted(shared)}
    counts = np.concatenate([np.diff(groom.offsets) for groom in grooms])
    ids = np.arange(len(counts), dtype=np.int32)
    return Groom(offsets=offsets_of(counts), ids=ids, group_names=names, maps=maps, **kept)


def joined_groups(grooms: tuple[Groom, ...]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the group of each strand of all grooms in turn, (S,) int32, and the names of groups; pure.

    A groom without groups is one of its own.
    """
    labels = [
        np.full(len(groom.ids), f"groom{i}") if groom.groups is None else labels_of(groom.groups, groom.group_names)
        for i, groom in enumerate(grooms)
    ]
    return numbered(np.concatenate(labels))


def free_tips(count: int) -> SimpleNamespace:
    """Return the fields of a groom that say of so many strands that their tips are free."""
    triangles = np.full(count, FREE, np.int32)
    frames = np.tile(np.eye(3, 4), (count, 1, 1))
    return SimpleNamespace(tip_triangles=triangles, tip_barycentrics=np.zeros((count, 3)), tip_frames=frames)


def joined_ends(ends: tuple[Ends, ...]) -> Ends:
    """Return the ends of all strands in turn; pure."""
    return Ends(*(np.concatenate([getattr(part, field.name) for part in ends]) for field in fields(Ends)))
