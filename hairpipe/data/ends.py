"""Where the ends of strands are led at one frame."""

import numpy as np

from hairpipe.data.value import value


@value
class Ends:
    """Both ends of every strand at one frame, as rigid motions from where the groom put them: x -> R x + t.

    Columns are those of R and then t [m], in the groom's own coordinates. A tip that is free is NaN; one that is held
    at a frame and free at the next is released at the first of the two.

    roots       (S, 3, 4) float64
    roots_rate  derivative of roots by time [1/s, m/s], same shape
    tips        the last segment and its end, same shape
    tips_rate   derivative of tips by time [1/s, m/s], same shape
    """

    roots: np.ndarray
    roots_rate: np.ndarray
    tips: np.ndarray
    tips_rate: np.ndarray
