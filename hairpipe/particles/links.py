"""Links between particles that are neighbours at rest, (5) and (6) of Bando, Chen, Nishita 2003.

With theta_ij the angle between the hair at i and the vector x_ij from i to j,

    a_ij = |cos theta_ij - cos theta_ji| / 2 where the cosines have opposite signs, else 0      (6)
    c_ij = a_ij l_ij                                                                            (5)

Pairs within 2 h_1 with a >= a_0 are linked. Of these the weakest, by c W(l, h_1), are removed while both ends have
more links than requested, and the end towards the tip keeps another link towards the root.

We differ from the paper: reaches follow from the number of neighbours, since hair of evenly spaced roots is uneven in
space; a particle without a link towards the root gets its strongest link below a_0.

Stiffness of links that preserves the modulus of hair while some fade, (7) to (14) of Bando, Chen, Nishita 2003.

With w = l k, k = c W(r, h_1) of (7), and its sums S over a particle's links to the tip and to the root, (10) and (11),
each side alone is a bar of the stiffness E A; a link has the mean of the values of both ends, (14):

    K = E (A_i w / S_tip,i + A_j w / S_root,j) / (2 l)                 = alpha k of (12) to (14)

We differ from the paper: the factor alpha of (13) divides by zero when the last link fades. Shares do not; both are at
most 1, so K <= E A / l for any link, even of torn hair. For every particle the strongest link to the root, w a^8 at
rest, does not fade below its value at rest: a particle that is pulled off returns, whereas the paper's is lost.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from hairpipe.errors import BadInput
from hairpipe.particles.model import Links, kernel, shape
from hairpipe.particles.sampling import Samples
from hairpipe.values import Particles

SURVEYED = 2000
"""Particles whose neighbours are counted."""
HALVINGS = 40


class LinkRule(NamedTuple):
    """The rule that selects linked neighbours.

    most       number of links that a particle keeps, N_n
    alignment  minimum a of a link, a_0
    linked     neighbours within 2 h_1, on average
    touching   neighbours within 2 h_2, on average
    """

    most: int
    alignment: float
    linked: float
    touching: float


class Candidates(NamedTuple):
    """Pairs of particles.

    pairs       the particle towards the root first, (E, 2) int64
    alignments  a_ij, (E,)
    weights     c_ij W(l_ij, h_1), (E,)
    """

    pairs: np.ndarray
    alignments: np.ndarray
    weights: np.ndarray


def link(samples: Samples, rule: LinkRule, line_density: float) -> Particles:
    """Link particles, which have equal shares of the mass of all hair; pure.

    line_density  line density of a fibre [kg/m]

    Raises BadInput if there are too few particles.
    """
    points, directions = samples.points, samples.directions
    deep = int(np.count_nonzero(samples.places.arcs < 0.0))
    masses = np.full(len(points), line_density * samples.length / (len(points) - deep))
    reach, span = (reach_with(points, neighbours) for neighbours in (rule.linked, rule.touching))
    links, alignments = find_links(points, directions, deep, reach, rule)
    return Particles(samples.hair, *samples.places, points, directions, masses, links, alignments, reach, span)


def reach_with(points: np.ndarray, neighbours: float) -> float:
    """Return h [m] such that particles have a number of neighbours within 2 h, on average; pure.

    Raises BadInput if there are not more particles than that.
    """
    if neighbours > len(points) - 1:
        message = f"{len(points)} particles cannot have {neighbours:g} neighbours each"
        raise BadInput(message, where="particles", right=f"more than {neighbours:g}")
    tree = KDTree(points)
    some = points[:: -(-len(points) // SURVEYED)]
    few = KDTree(some)
    low = 0.0
    high = float(np.linalg.norm(np.ptp(points, axis=0)))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        found = few.count_neighbors(tree, middle) / len(some) - 1.0
        low, high = (middle, high) if found < neighbours else (low, middle)
    return 0.5 * high


def find_links(
    points: np.ndarray, directions: np.ndarray, deep: int, reach: float, rule: LinkRule
) -> tuple[np.ndarray, np.ndarray]:
    """Return the links, (E, 2) int32, ordered by their first particle, towards the root, and their a_ij, (E,); pure.

    points      [m], (N, 3); the first `deep` of them are below the skin
    directions  unit vectors, (N, 3)
    reach       h_1 [m]

    Raises BadInput if particles are not linked to a root.
    """
    near = _candidates(points, directions, deep, reach)
    near = Candidates(*(column[near.alignments >= rule.alignment] for column in near))
    incoming = np.bincount(near.pairs[:, 1], minlength=len(points))
    incoming[:deep] = 1
    near = _joined([near, *(_strongest(points, directions, reach, j) for j in np.flatnonzero(incoming == 0))])
    kept = _pruned(near, len(points), rule.most)
    pairs, alignments = near.pairs[kept], near.alignments[kept]
    _check_connected(pairs, len(points), deep)
    return pairs.astype(np.int32), alignments


def _candidates(points: np.ndarray, directions: np.ndarray, deep: int, reach: float) -> Candidates:
    """Return all pairs within reach that are aligned at all, but for those below the skin."""
    pairs = KDTree(points).query_pairs(2.0 * reach, output_type="ndarray").astype(np.int64)
    pairs = pairs[pairs.max(axis=1) >= deep]
    here, there, lengths = _cosines(points, directions, pairs)
    aligned = here * there > 0.0
    pairs = np.where((here > 0.0)[:, None], pairs, pairs[:, ::-1])
    alignments = 0.5 * np.abs(here + there)
    return _weighed(pairs[aligned], alignments[aligned], lengths[aligned], reach)


def _strongest(points: np.ndarray, directions: np.ndarray, reach: float, j: int) -> Candidates:
    """Return the pair by which a particle is led best by any that is behind it, if there is one."""
    others = np.flatnonzero(np.linalg.norm(points - points[j], axis=1) < 2.0 * reach)
    pairs = np.stack([others[others != j], np.full(len(others) - 1, j)], axis=1)
    here, there, lengths = _cosines(points, directions, pairs)
    behind = (there > 0.0) & (here + there != 0.0)
    found = _weighed(pairs[behind], 0.5 * np.abs(here + there)[behind], lengths[behind], reach)
    best = np.argsort(-found.weights, kind="stable")[:1]
    return Candidates(*(column[best] for column in found))


def _cosines(
    points: np.ndarray, directions: np.ndarray, pairs: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the cosines of the hair at both ends with the way from the first to the second, and its length [m]."""
    ways = points[pairs[:, 1]] - points[pairs[:, 0]]
    lengths = np.linalg.norm(ways, axis=1)
    ways /= np.maximum(lengths, 1e-12)[:, None]
    here, there = (np.sum(directions[pairs[:, end]] * ways, axis=1) for end in range(2))
    return here, there, lengths


def _weighed(pairs: np.ndarray, alignments: np.ndarray, lengths: np.ndarray, reach: float) -> Candidates:
    return Candidates(pairs, alignments, alignments * lengths * kernel(lengths, reach))


def _joined(parts: list[Candidates]) -> Candidates:
    """Return all pairs, ordered."""
    pairs, alignments, weights = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    return Candidates(pairs[order], alignments[order], weights[order])


def _pruned(near: Candidates, count: int, most: int) -> np.ndarray:
    """Return which of the pairs stay, ascending."""
    links = np.bincount(near.pairs.ravel(), minlength=count).tolist()
    towards_root = np.bincount(near.pairs[:, 1], minlength=count).tolist()
    kept = np.ones(len(near.pairs), bool)
    order = np.argsort(near.weights, kind="stable")
    for k, (i, j) in zip(order.tolist(), near.pairs[order].tolist(), strict=True):
        if links[i] > most and links[j] > most and towards_root[j] > 1:
            kept[k] = False
            links[i] -= 1
            links[j] -= 1
            towards_root[j] -= 1
    return np.flatnonzero(kept)


def _check_connected(pairs: np.ndarray, count: int, deep: int) -> None:
    """Raise BadInput where particles are not linked to a root."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    loose = ~np.isin(labels, labels[:deep])
    if loose.any():
        message = f"{np.count_nonzero(loose)} of {count - deep} particles are not linked to a root"
        raise BadInput(message, where="particles", right="more particles, or neighbours")


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
