"""Several grooms as one."""

from dataclasses import fields

import numpy as np

from hairpipe.data import Ends, Groom
from hairpipe.groom.adopting import offsets_of


def joined_strands(grooms: tuple[Groom, ...]) -> Groom:
    """Return the strands of all grooms in turn, numbered anew; pure.

    Roots keep their triangles, so that grooms on a body belong to the same body.
    """
    kept = {
        name: np.concatenate([getattr(groom, name) for groom in grooms])
        for name in ("points", "root_triangles", "root_barycentrics", "root_frames", "root_uv")
    }
    counts = np.concatenate([np.diff(groom.offsets) for groom in grooms])
    return Groom(offsets=offsets_of(counts), ids=np.arange(len(counts), dtype=np.int32), **kept)


def joined_ends(ends: tuple[Ends, ...]) -> Ends:
    """Return the ends of all strands in turn; pure."""
    return Ends(*(np.concatenate([getattr(part, field.name) for part in ends]) for field in fields(Ends)))
