"""Particles that represent the hair of a groom, Sec. 3.2 of Bando, Chen, Nishita 2003.

"strands": roots at a spacing, and points on their hair at the same spacing. As with the paper's distance (3), the
sampling is even on the scalp and along the hair, independent of the shape of hair in space.
"even":    points of all hair at a spacing in space; they cover it evenly, on otherwise unrelated hairs.

In both cases additional particles lie below the skin, down to 2.5 spacings, and move with the root. The spacing
follows from the requested number of particles.

We differ from the paper: hair comes from a groom, so there is no map of the scalp to a square, and no beam (4) to grow
it; masses are equal, as unequal ones double the range of frequencies.
"""

from typing import Literal, NamedTuple

import numpy as np
from scipy.spatial import KDTree

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import axes_of
from hairpipe.geometry.sorting import morton_order
from hairpipe.values import Groom
from hairpipe.values.groom import segment_lengths
from hairpipe.values.random_streams import stream
from hairpipe.values.strand_arrays import take

Sampling = Literal["strands", "even"]
DEPTH = 2.5
"""Depth of particles below the skin [spacings]: links reach 2.4."""
CLOSE, ENOUGH = 0.002, 0.1
"""Relative errors of the number of particles: tolerance of the search, and largest accepted one."""
TRIES = 60


class Places(NamedTuple):
    """Places on strands.

    strands  strand of each, (n,)
    arcs     arc length from the skin, negative below it [m], (n,)
    """

    strands: np.ndarray
    arcs: np.ndarray


class Samples(NamedTuple):
    """Particles without their links; those below the skin come first.

    hair        strands on which they lie
    places      places on these
    points      [m], (N, 3)
    directions  unit vectors to the tip, (N, 3)
    length      length of all represented hair [m]
    """

    hair: Groom
    places: Places
    points: np.ndarray
    directions: np.ndarray
    length: float


class Lines(NamedTuple):
    """The axes of hair.

    points   of all strands [m], (p, 3)
    offsets  strand s owns points offsets[s]:offsets[s+1], (S+1,)
    arcs     arc lengths of the points from their root [m], (p,)
    ways     directions at the points, unit vectors, (p, 3)
    roots    directions below the skin, unit vectors, (S, 3)
    """

    points: np.ndarray
    offsets: np.ndarray
    arcs: np.ndarray
    ways: np.ndarray
    roots: np.ndarray

    @property
    def lengths(self) -> np.ndarray:
        """Of the strands [m], (S,)."""
        return self.arcs[self.offsets[1:] - 1]

    @property
    def owners(self) -> np.ndarray:
        """The strand of every point, (p,)."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))

    def at(self, places: Places) -> tuple[np.ndarray, np.ndarray]:
        """Return points [m] and directions, (n, 3) each; below the skin they go along `roots`."""
        strands, arcs = places
        reach = 1.0 + float(self.lengths.max())
        after = np.searchsorted(self.arcs + reach * self.owners, arcs + reach * strands, side="right")
        below = np.clip(after - 1, self.offsets[strands], self.offsets[strands + 1] - 2)
        span = np.maximum(self.arcs[below + 1] - self.arcs[below], 1e-12)
        share = np.clip((arcs - self.arcs[below]) / span, 0.0, 1.0)[:, None]
        points = (1.0 - share) * self.points[below] + share * self.points[below + 1]
        ways = (1.0 - share) * self.ways[below] + share * self.ways[below + 1]
        points += np.minimum(arcs, 0.0)[:, None] * self.roots[strands]
        ways = np.where((arcs < 0.0)[:, None], self.roots[strands], ways)
        return points, ways / np.linalg.norm(ways, axis=1)[:, None]


def sample(groom: Groom, count: int, sampling: Sampling, seed: int) -> Samples:
    """Choose a number of free particles, and those below the skin; pure.

    Raises BadInput if the groom has no strands, or too few points.
    """
    if not len(groom.ids):
        raise BadInput("no hair grows from the scalp", where="in.groom", right="a groom with strands")
    if count > len(groom.points):
        message = f"{count} particles on a groom of {len(groom.points)} points"
        raise BadInput(message, where="particles", right="fewer particles, or a groom of more strands")
    lines = _lines_of(groom)
    choose = _OnStrands(lines, seed) if sampling == "strands" else _InSpace(lines, seed)
    free, spacing = _with_count(choose, count, float(np.ptp(lines.points, axis=0).max()))
    parts = list[Places]()
    for part in (choose.below(free, spacing), free):
        order = morton_order(lines.at(part)[0])
        parts.append(Places(part.strands[order], part.arcs[order]))
    both = Places(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
    points, directions = lines.at(both)
    used, whose = np.unique(both.strands, return_inverse=True)
    places = Places(whose.astype(np.int32), both.arcs)
    return Samples(
        take(groom, used), places, points, directions, float(segment_lengths(groom.points, groom.offsets).sum())
    )


def _lines_of(groom: Groom) -> Lines:
    points = axes_of(groom)
    offsets = groom.offsets
    steps = np.diff(points, axis=0, prepend=points[:1])
    sizes = np.linalg.norm(steps, axis=1)
    steps[offsets[:-1]], sizes[offsets[:-1]] = 0.0, 0.0
    sums = np.cumsum(sizes)
    arcs = sums - np.repeat(sums[offsets[:-1]], np.diff(offsets))
    ahead = np.roll(steps, -1, axis=0)
    ahead[offsets[1:] - 1] = 0.0
    ways = _units(steps + ahead)
    # t_r of (4), with w_t = w_n: at least 45 degrees from the skin. A straight extension below the skin of hair that
    # begins along it, or inwards, would come out elsewhere.
    starts = ways[offsets[:-1]]
    normals = groom.root_frames[:, :, 2]
    upright = np.sum(starts * normals, axis=1)
    across = _units(starts - upright[:, None] * normals)
    roots = np.where((upright < np.sqrt(0.5))[:, None], _units(across + normals), starts)
    return Lines(points, offsets, arcs, ways, roots)


def _units(vectors: np.ndarray) -> np.ndarray:
    """Return vectors, (n, 3), at length 1; those without length as they are."""
    sizes = np.linalg.norm(vectors, axis=1)[:, None]
    return vectors / np.where(sizes > 0.0, sizes, 1.0)


class _OnStrands:
    """Roots a spacing apart, and points a spacing apart on their hair, from a place of its own on each."""

    def __init__(self, lines: Lines, seed: int) -> None:
        self.lines, self.tree = lines, KDTree(lines.points[lines.offsets[:-1]])
        self.order = stream(seed, "roots of particles").permutation(self.tree.n)
        self.shifts = stream(seed, "first particles").uniform(size=self.tree.n)

    def free(self, spacing: float) -> Places:
        strands = darts(self.tree, self.order, spacing)
        return self._along(strands, spacing, 0.0, self.lines.lengths[strands] / spacing)

    def below(self, places: Places, spacing: float) -> Places:
        return self._along(np.unique(places.strands), spacing, -DEPTH, 0.0)

    def _along(self, strands: np.ndarray, spacing: float, first: float, last: np.ndarray | float) -> Places:
        """Return the places on strands from the first on to before the last, both in spacings."""
        shifts = self.shifts[strands]
        begin, end = np.ceil(first - shifts), np.ceil(last - shifts)
        counts = np.maximum(end - begin, 0.0).astype(int)
        steps = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        return Places(np.repeat(strands, counts), spacing * (np.repeat(begin + shifts, counts) + steps))


class _InSpace:
    """Points of all hair that are a spacing apart."""

    def __init__(self, lines: Lines, seed: int) -> None:
        self.lines, self.seed, self.tree = lines, seed, KDTree(lines.points)
        self.order = stream(seed, "particles in space").permutation(len(lines.points))

    def free(self, spacing: float) -> Places:
        chosen = darts(self.tree, self.order, spacing)
        return Places(self.lines.owners[chosen], self.lines.arcs[chosen])

    def below(self, places: Places, spacing: float) -> Places:
        steps = np.arange(1, 1 + int(np.ceil(4 * DEPTH)))
        count = len(self.lines.offsets) - 1
        deep = Places(np.repeat(np.arange(count), len(steps)), -0.25 * spacing * np.tile(steps, count))
        deep = Places(*(column[deep.arcs >= -DEPTH * spacing] for column in deep))
        points = self.lines.at(deep)[0]
        order = stream(self.seed, "particles below the skin").permutation(len(points))
        room = KDTree(self.lines.at(places)[0]).query(points)[0] >= spacing
        kept = darts(KDTree(points), order[room[order]], spacing)
        return Places(deep.strands[kept], deep.arcs[kept])


def darts(tree: KDTree, order: np.ndarray, spacing: float) -> np.ndarray:
    """Select points of a tree in an order, each at least a spacing [m] from those selected; return them, ascending.

    Source: R. L. Cook, Stochastic sampling in computer graphics, 1986: dart throwing.
    """
    taken = []
    blocked = bytearray(tree.n)
    marks = np.frombuffer(blocked, np.uint8)
    for k in order.tolist():
        if not blocked[k]:
            taken.append(k)
            marks[tree.query_ball_point(tree.data[k], spacing)] = 1
    return np.sort(np.array(taken, np.int64))


def _with_count(choose: _OnStrands | _InSpace, count: int, size: float) -> tuple[Places, float]:
    """Find the spacing [m] at which there are so many; their number goes about as its third power."""
    spacing = size / count ** (1.0 / 3.0)
    best = (np.inf, Places(np.empty(0), np.empty(0)), 0.0)
    for _ in range(TRIES):
        places = choose.free(spacing)
        off = abs(len(places.arcs) / count - 1.0)
        if off < best[0]:
            best = (off, places, spacing)
        if off <= CLOSE:
            break
        spacing *= (max(len(places.arcs), 1) / count) ** (1.0 / 3.0)
    if best[0] > ENOUGH:
        message = f"{count} particles do not fit the groom: {len(best[1].arcs)} do"
        raise BadInput(message, where="particles", right="another number, or a groom of more strands")
    return best[1], best[2]
