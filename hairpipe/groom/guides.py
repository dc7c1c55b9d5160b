"""Guides next to the hair that follows them, as grooms of other programs have them."""
# pyright: reportCallIssue=false

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.groom.key_weights import keys_among, weigh_keys
from hairpipe.groom.sampling import joined_strands
from hairpipe.values import Groom, Strands
from hairpipe.values.strand_arrays import offsets_of, take


class Guided(NamedTuple):
    groom: Groom  # hair, then guides, marked
    hair: Mapping[int, Strands] | None  # both at every frame; None: at rest
    closest: tuple[np.ndarray, np.ndarray] | None  # ids and weights of three guides of each strand, (S, 3) each


def with_guides(
    groom: Groom,
    hair: Mapping[int, Strands] | None,
    keys: Groom | None,
    key_hair: Mapping[int, Strands] | None,
    parting: float,
) -> Guided:
    """Return a groom with the keys as guides after it, with ids of their own; pure.

    hair      hair of the groom at every frame; key_hair: that of the keys, by default the same strands of `hair`
    parting   maximum angle between a strand and its guides at rest [deg]
    Raises BadInput where the motion of the guides is not known.
    """
    if keys is None:
        return Guided(groom, hair, None)
    own = keys_among(groom, keys)
    found = weigh_keys(keys, groom, parting)
    ids = np.concatenate([groom.ids, int(groom.ids.max()) + 1 + np.arange(len(keys.ids))]).astype(np.int32)
    marks = np.arange(len(ids)) >= len(groom.ids)
    both = replace(joined_strands((groom, keys)), ids=ids, guides=marks)
    closest = np.where((own >= 0)[:, None], own[:, None], found.keys)
    weights = np.where((own >= 0)[:, None], (1.0, 0.0, 0.0), found.weights)
    itself = np.arange(len(keys.ids))
    closest = ids[len(groom.ids) + np.concatenate([closest, np.tile(itself[:, None], (1, 3))])]
    weights = np.concatenate([weights, np.tile((1.0, 0.0, 0.0), (len(itself), 1))])
    if hair is None:
        return Guided(both, None, (closest, weights))
    strands = np.zeros(0, np.int64)
    if key_hair is None:
        if len(np.unique(own[own >= 0])) < len(itself):
            raise BadInput("guides are not strands of the groom", where="in.keys", right="in.key_hair: their motion")
        strands = np.flatnonzero(own >= 0)[np.argsort(own[own >= 0])]
    return Guided(both, Both(hair, key_hair, strands), (closest, weights))


class Both(Mapping[int, Strands]):
    """Hair and guides at the frames of the hair; the guides are hair of their own, or strands of the hair, (K,)."""

    def __init__(self, hair: Mapping[int, Strands], guides: Mapping[int, Strands] | None, strands: np.ndarray) -> None:
        self.hair, self.guides, self.strands = hair, guides, strands

    def __getitem__(self, frame: int) -> Strands:
        first = self.hair[frame]
        second = take(first, self.strands) if self.guides is None else self.guides[frame]
        counts = np.concatenate([np.diff(first.offsets), np.diff(second.offsets)])
        arrays = (np.concatenate([getattr(s, name) for s in (first, second)]) for name in ("points", "velocities"))
        widths = None
        if first.widths is not None or second.widths is not None:
            widths = np.concatenate([first.widths_at_points(), second.widths_at_points()])
        return Strands(*arrays, offsets_of(counts), first.diameter, widths)

    def __iter__(self) -> Iterator[int]:
        return iter(self.hair)

    def __len__(self) -> int:
        return len(self.hair)
