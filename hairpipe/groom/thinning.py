"""Some strands of a groom, evenly among the others."""

import numpy as np

from hairpipe.data import Groom
from hairpipe.groom.adopting import take_strands


def thinned(groom: Groom, every: int) -> Groom:
    """Return every n-th strand of a groom, with the id that it has; pure.

    Strands of a groom stand in an order in which neighbours are near each other (`ordering.py`), so what is left is
    about as even as all of it was.
    """
    strands = np.arange(every // 2, len(groom.ids), every)
    points, offsets = take_strands(groom.points, groom.offsets, strands)
    names = ("ids", "root_triangles", "root_barycentrics", "root_frames", "root_uv")
    return Groom(points, offsets, **{name: getattr(groom, name)[strands] for name in names})
