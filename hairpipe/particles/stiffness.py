"""Stiffness of links that preserves the modulus of hair while some fade, (7) to (14) of Bando, Chen, Nishita 2003.

With w = l k, k = c W(r, h_1) of (7), and its sums S over a particle's links to the tip and to the root, (10) and (11),
each side alone is a bar of the stiffness E A; a link has the mean of the values of both ends, (14):

    K = E (A_i w / S_tip,i + A_j w / S_root,j) / (2 l)                 = alpha k of (12) to (14)

We differ from the paper: the factor alpha of (13) divides by zero when the last link fades. Shares do not; both are at
most 1, so K <= E A / l for any link, even of torn hair. For every particle the strongest link to the root, w a^8 at
rest, does not fade below its value at rest: a particle that is pulled off returns, whereas the paper's is lost.
"""

import numpy as np
from numba import njit

from hairpipe.particles.model import Links
from hairpipe.particles.smoothing_kernel import shape


@njit(cache=True, error_model="numpy")
def measure_links(links: Links, points: np.ndarray, ways: np.ndarray) -> None:
    """Write direction from the first to the second end, and length [m], of every link, (E, 4), in place."""
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
        r = np.sqrt(x * x + y * y + z * z)
        over = 1.0 / r if r > 0.0 else 0.0  # A link of no length has no direction.
        ways[e, 0] = over * x
        ways[e, 1] = over * y
        ways[e, 2] = over * z
        ways[e, 3] = r


@njit(cache=True, error_model="numpy")
def stiffen(links: Links, reach: float, axial: np.ndarray, ways: np.ndarray, stiffness: np.ndarray) -> None:
    """Write K of every link [N/m], (E,), in place.

    reach  h_1 [m]
    axial  E A of every particle [N], (N,)
    ways   vectors of the links, as `measure_links` writes them
    """
    sums = np.zeros((len(axial), 2))
    over = 1.0 / reach
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        # Beyond `keeps` a link fades no farther, so that what is pulled off comes back.
        weight = links.strength[e] * shape(min(ways[e, 3], links.keeps[e]) * over)
        stiffness[e] = weight
        sums[i, 1] += weight
        sums[j, 0] += weight
    for k in range(len(sums)):
        sums[k, 0] = 0.5 * axial[k] / sums[k, 0] if sums[k, 0] > 0.0 else 0.0
        sums[k, 1] = 0.5 * axial[k] / sums[k, 1] if sums[k, 1] > 0.0 else 0.0
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        stiffness[e] *= (sums[i, 1] + sums[j, 0]) / links.lengths[e]
