"""Some strands of a groom, evenly among the others."""

import numpy as np

from hairpipe.data import Groom
from hairpipe.groom.sampling import take


def thinned(groom: Groom, every: int) -> Groom:
    """Return every n-th strand of a groom, with the id that it has; pure.

    Strands of a groom stand in an order in which neighbours are near each other (`ordering.py`), so what is left is
    about as even as all of it was.
    """
    return take(groom, np.arange(every // 2, len(groom.ids), every))
