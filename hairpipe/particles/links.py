"""Links between particles: their choice, their stiffness, and the directions of hair that they predict.

With theta_ij the angle between the hair at i and the vector x_ij from i to j, (5) and (6) of Bando, Chen, Nishita 2003:

    a_ij = |cos theta_ij - cos theta_ji| / 2 where the cosines have opposite signs, else 0      (6)
    c_ij = a_ij l_ij                                                                            (5)

Pairs within 2 h_1 that are neighbours at rest with a >= a_0 are linked. Of these the weakest, by c W(l, h_1), are
removed while both ends have more links than requested, and the end towards the tip keeps another link towards the root.

We differ from the paper: reaches follow from the number of neighbours, since hair of evenly spaced roots is uneven in
space; a particle without a link towards the root gets its strongest link below a_0.

Stiffness preserves the modulus of hair while some links fade, (7) to (14). With w = l k, k = c W(r, h_1) of (7), and
its sums S over a particle's links to the tip and to the root, (10) and (11), each side alone is a bar of the stiffness
E A; a link has the mean of the values of both ends, (14):

    K = E (A_i w / S_tip,i + A_j w / S_root,j) / (2 l)                 = alpha k of (12) to (14)

We differ from the paper: the factor alpha of (13) divides by zero when the last link fades. Shares do not; both are at
most 1, so K <= E A / l for any link, even of torn hair. For every particle the strongest link to the root, w a^8 at
rest, does not fade below its value at rest: a particle that is pulled off returns, whereas the paper's is lost.

Every link predicts the direction of the hair at its end i, (15): its own direction d, rotated by the angle theta at
rest, in the plane of d and the present direction of the hair,

    t_i <- unit of sum K (cos theta d + sin theta p / max(|p|, 1e-3)),   p = t_i - (t_i . d) d

We differ from the paper if t_i is parallel to d, so that the plane is undefined, and for particles without links:
there the hair keeps its direction.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from hairpipe.errors import BadInput
from hairpipe.geometry.vec3 import flattened, length, minus, row
from hairpipe.particles.model import Links, kernel, shape
from hairpipe.particles.sampling import Samples
from hairpipe.values import Particles

SURVEYED = 2000
"""Particles whose neighbours are counted."""
HALVINGS = 40
LEAST = 1e-3
"""Sine of the angle with a link below which a direction is not turned by it whole."""


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
    """Return h [m] with which particles have so many neighbours within 2 h, on average; BadInput if there are fewer."""
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

    points  [m], (N, 3), with unit directions, (N, 3); the first `deep` are below the skin; reach  h_1 [m]

    Raises BadInput if particles are not linked to a root.
    """
    pairs = KDTree(points).query_pairs(2.0 * reach, output_type="ndarray").astype(np.int64)
    pairs = pairs[pairs.max(axis=1) >= deep]
    here, there, alignments, weights = _weigh(points, directions, pairs, reach)
    pairs = np.where((here > 0.0)[:, None], pairs, pairs[:, ::-1])
    aligned = (here * there > 0.0) & (alignments >= rule.alignment)
    found = [(pairs[aligned], alignments[aligned], weights[aligned])]
    incoming = np.bincount(pairs[aligned][:, 1], minlength=len(points))
    for j in deep + np.flatnonzero(incoming[deep:] == 0):
        # The strongest link from any particle behind this one, however badly aligned.
        others = np.flatnonzero(np.linalg.norm(points - points[j], axis=1) < 2.0 * reach)
        linked = np.stack([others[others != j], np.full(len(others) - 1, j)], axis=1)
        here, there, alignments, weights = _weigh(points, directions, linked, reach)
        behind = np.flatnonzero((there > 0.0) & (here + there != 0.0))
        best = behind[np.argsort(-weights[behind], kind="stable")[:1]]
        found.append((linked[best], alignments[best], weights[best]))
    pairs, alignments, weights = (np.concatenate(columns) for columns in zip(*found, strict=True))
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    kept = order[_pruned(pairs[order], weights[order], len(points), rule.most)]
    pairs = pairs[kept]
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    labels = connected_components(graph, directed=False)[1]
    loose = ~np.isin(labels, labels[:deep])
    if loose.any():
        message = f"{np.count_nonzero(loose)} of {len(points) - deep} particles are not linked to a root"
        raise BadInput(message, where="particles", right="more particles, or neighbours")
    return pairs.astype(np.int32), alignments[kept]


def _weigh(points: np.ndarray, directions: np.ndarray, pairs: np.ndarray, reach: float) -> tuple[np.ndarray, ...]:
    """Return the cosines of the hair at both ends with the way from the first to the second, a_ij and c_ij W."""
    ways = points[pairs[:, 1]] - points[pairs[:, 0]]
    lengths = np.linalg.norm(ways, axis=1)
    ways /= np.maximum(lengths, 1e-12)[:, None]
    here, there = (np.sum(directions[pairs[:, end]] * ways, axis=1) for end in range(2))
    alignments = 0.5 * np.abs(here + there)
    return here, there, alignments, alignments * lengths * kernel(lengths, reach)


def _pruned(pairs: np.ndarray, weights: np.ndarray, count: int, most: int) -> np.ndarray:
    """Return which of the pairs stay, ascending."""
    links = np.bincount(pairs.ravel(), minlength=count).tolist()
    towards_root = np.bincount(pairs[:, 1], minlength=count).tolist()
    kept = np.ones(len(pairs), bool)
    order = np.argsort(weights, kind="stable")
    for k, (i, j) in zip(order.tolist(), pairs[order].tolist(), strict=True):
        if links[i] > most and links[j] > most and towards_root[j] > 1:
            kept[k] = False
            links[i] -= 1
            links[j] -= 1
            towards_root[j] -= 1
    return np.flatnonzero(kept)


@njit(cache=True, error_model="numpy")
def measure_links(links: Links, points: np.ndarray, ways: np.ndarray) -> None:
    """Write direction from the first to the second end, and length [m], of every link, (E, 4), in place."""
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        way = minus(row(points, j), row(points, i))
        r = length(way)
        over = 1.0 / r if r > 0.0 else 0.0  # A link of no length has no direction.
        for c in range(3):
            ways[e, c] = over * way[c]
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
        for side in range(2):
            sums[k, side] = 0.5 * axial[k] / sums[k, side] if sums[k, side] > 0.0 else 0.0
    for e in range(len(links.ends)):
        i, j = links.ends[e, 0], links.ends[e, 1]
        stiffness[e] *= (sums[i, 1] + sums[j, 0]) / links.lengths[e]


@njit(cache=True, error_model="numpy")
def turn_directions(links: Links, ways: np.ndarray, stiffness: np.ndarray, deep: int, directions: np.ndarray) -> None:
    """Turn the directions of free particles by links of some stiffness, in place; the `deep` turn with their roots."""
    sums = np.zeros_like(directions)
    for e in range(len(links.ends)):
        d = row(ways, e)
        for end in range(2):
            k, cosine = links.ends[e, end], links.cosines[e, end]
            p = flattened(row(directions, k), d)
            along = stiffness[e] * cosine
            # Nearly along d the plane is arbitrary: the turn fades out instead of jumping.
            across = stiffness[e] * np.sqrt(max(1.0 - cosine * cosine, 0.0)) / max(length(p), LEAST)
            for c in range(3):
                sums[k, c] += along * d[c] + across * p[c]
    for k in range(deep, len(directions)):
        size = length(row(sums, k))
        if size > 0.0:
            for c in range(3):
                directions[k, c] = sums[k, c] / size


@njit(cache=True, error_model="numpy")
def redirect(links, reach, axial, deep, points, stiffness, directions):
    """Turn directions, and write the stiffness of links [N/m], (E,), at points [m], (N, 3), in place.

    reach, axial  as `stiffen` takes them
    """
    ways = np.empty((len(links.ends), 4))
    measure_links(links, points, ways)
    stiffen(links, reach, axial, ways, stiffness)
    turn_directions(links, ways, stiffness, deep, directions)
