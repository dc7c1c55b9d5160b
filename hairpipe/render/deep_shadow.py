"""Deep shadow maps: for every texel before a lamp, the transmittance of hair and body by depth.

Lokovic and Veach 2000. Every strand covers a share of the texels that it crosses and attenuates light there, see
OPACITY; the body attenuates as SOLID hairs. We differ from the paper: coverage is computed from the area of a segment
projected to the lamp, shared among the four nearest texels, not from samples in each; texels are filtered already.

Transmittance along a ray is a step function of depth: the product of (1 - opacity) of all fragments in front. It is
compressed to a piecewise linear function within a tolerance of the steps, with two knots at one depth for a jump
(Sec. 3.2: each vertex narrows the interval of slopes from the last knot, until it is empty).
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.render.lights import Light
from hairpipe.render.shadows import BIAS, FINE, SOLID, apply, cells_of, front
from hairpipe.values import Mesh
from hairpipe.values.strand_arrays import rows_of


@njit(cache=True, nogil=True)
def compress(depths: np.ndarray, opacities: np.ndarray, tolerance: float, knots: np.ndarray) -> int:
    """Compress the transmittance behind n fragments, depths ascending, into at most 2 n knots; return their number.

    Knots are depth and transmittance, not increasing, (2 n, 2) float32.
    """
    begin = depths[0]
    value = 1.0
    count = 1
    knots[0, 0], knots[0, 1] = begin, value
    low = -np.inf
    high = 0.0
    last = begin
    through = 1.0
    for n in range(len(depths)):
        z = depths[n]
        for behind in range(2):  # every step has two vertices
            if behind:
                through *= 1.0 - opacities[n]
            if z > begin:
                least, most = slopes(through - value, z - begin, tolerance)
                if least <= high and most >= low:  # One line from the last knot still meets all vertices so far.
                    low = max(low, least)
                    high = min(high, most)
                    last = z
                    continue
                begin, value = last, value + 0.5 * (low + high) * (last - begin)
                knots[count, 0], knots[count, 1] = begin, value
                count = count + 1
                low = -np.inf
                high = 0.0
            if z > begin:
                least, most = slopes(through - value, z - begin, tolerance)
                low = least
                high = min(most, 0.0)
                last = z
            elif value - through > tolerance:  # A jump at the depth of the knot itself, which no slope can follow.
                value = through
                knots[count, 0], knots[count, 1] = begin, value
                count += 1
    if last > begin:
        knots[count, 0] = last
        knots[count, 1] = value + 0.5 * (low + high) * (last - begin)
        count += 1
    return count


@njit(cache=True, nogil=True, inline="always")
def slopes(rise: float, run: float, tolerance: float) -> tuple[float, float]:
    """Return the least and the greatest slope that end within a tolerance of a rise; the least is never positive."""
    return min((rise - tolerance) / run, 0.0), (rise + tolerance) / run


@njit(cache=True, nogil=True)
def transmittance(knots: np.ndarray, begin: int, end: int, depth: float) -> float:
    """Return the transmittance at a depth, by knots[begin:end]: 1 before the first, the last behind the last."""
    if begin == end or depth < knots[begin, 0]:
        return 1.0
    low, high = begin, end
    while high - low > 1:
        middle = (low + high) // 2
        if knots[middle, 0] <= depth:
            low = middle
        else:
            high = middle
    if low + 1 == end:
        return knots[low, 1]
    part = (depth - knots[low, 0]) / (knots[low + 1, 0] - knots[low, 0])
    return knots[low, 1] + part * (knots[low + 1, 1] - knots[low, 1])


TEXELS = 512  # number of texels along an edge of the map
OPACITY = 0.15
"""Opacity of a shaded hair, per hair that a ray crosses: exp(-OPACITY) is transmitted or scattered around it."""
TOLERANCE = 0.02  # tolerance of the compressed transmittance
LEAST = 1e-4  # transmittance that is treated as zero


class DeepShadow(NamedTuple):
    """Transmittance from a lamp to the places behind the texels of a map."""

    light: Light
    to_cells: np.ndarray  # motion of world points to places on the map and depths from the lamp [texels], (3, 4)
    cell: float  # edge of a texel [m]
    starts: np.ndarray  # texel (i, j) has knots[starts[t]:starts[t+1]], t = TEXELS i + j, (TEXELS^2 + 1,) int64
    knots: np.ndarray  # depth [texels] and transmittance, see `compress`, (k, 2) float32

    def between(self, points: np.ndarray) -> np.ndarray:
        """Optical depths between the lamp and world points (n, 3), in hairs as `Shadow.between`, (n,) float64."""
        return look_up_deep(self.starts, self.knots, apply(self.to_cells, points))


def cast_deep_shadow(
    light: Light,
    centre: np.ndarray,
    radius: float,
    points: np.ndarray,
    offsets: np.ndarray,
    width: float | np.ndarray,
    body: Mesh,
) -> DeepShadow:
    """Cast the shadow of hair and body away from a lamp, as `cast_shadow` does; equal on any number of threads."""
    cell, to_cells = cells_of(light, centre, radius, TEXELS)
    places = apply(to_cells, points)
    widths = np.broadcast_to(width, len(points)) / cell
    rays = front(apply(to_cells, body.points), body.triangles, FINE, TEXELS)
    solid = np.sort(rays.reshape(TEXELS, FINE, TEXELS, FINE).swapaxes(1, 2).reshape(-1, FINE * FINE), axis=1)
    counts = np.isfinite(solid).sum(axis=1)
    scatter(counts, np.empty((0, 2), np.float32), places, offsets, widths)
    starts = starts_of(counts)
    fragments = np.empty((starts[-1], 2), np.float32)
    ends = starts[:-1].copy()
    lay_body(ends, fragments, solid)
    scatter(ends, fragments, places, offsets, widths)
    loose = np.empty((2 * len(fragments), 2), np.float32)
    compress_all(starts, fragments, counts, loose)
    return DeepShadow(light, to_cells, cell, starts_of(counts), loose[rows_of(2 * starts[:-1], counts)])


def starts_of(counts: np.ndarray) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(counts)])


@njit(cache=True, nogil=True)
def lay_body(ends: np.ndarray, fragments: np.ndarray, solid: np.ndarray) -> None:
    """Add the front of the body, BIAS behind it, to the fragments of texels, by the hits of their rays, ascending."""
    step = (1.0 - math.exp(-OPACITY * SOLID)) / solid.shape[1]
    for t in range(len(solid)):
        for n, depth in enumerate(solid[t]):
            if depth < np.inf:
                fragments[ends[t], 0] = depth + BIAS
                # The product of 1 - opacity then falls by equal steps: each ray has the same share.
                fragments[ends[t], 1] = step / (1.0 - n * step)
                ends[t] += 1


@njit(cache=True, nogil=True)
def scatter(
    ends: np.ndarray, fragments: np.ndarray, places: np.ndarray, offsets: np.ndarray, widths: np.ndarray
) -> None:
    """Add depth and opacity of strands to the fragments of every texel, which end at `ends`, in place.

    Pieces of a segment are at most a texel long, so that their shares on the four nearest texels have no gaps. Without
    memory for fragments, these are counted only. Places (p, 3) and widths in texels.
    """
    for s in range(len(offsets) - 1):
        for i in range(offsets[s], offsets[s + 1] - 1):
            x, y, z = places[i, 0], places[i, 1], places[i, 2]
            dx, dy, dz = places[i + 1, 0] - x, places[i + 1, 1] - y, places[i + 1, 2] - z
            length = math.hypot(dx, dy)
            width = 0.5 * (widths[i] + widths[i + 1])
            pieces = math.ceil(min(length, TEXELS))  # a longer segment is invalid
            for n in range(pieces):
                t = (n + 0.5) / pieces
                add(ends, fragments, x + t * dx, y + t * dy, z + t * dz, width * length / pieces)


@njit(cache=True, nogil=True)
def add(ends: np.ndarray, fragments: np.ndarray, x: float, y: float, z: float, area: float) -> None:
    """Share an area among the four texels around a place, in place; a place outside the map is ignored."""
    top = TEXELS - 0.5
    if not (0.5 <= x < top and 0.5 <= y < top and 0.5 <= z < top):
        return
    i, j = int(x - 0.5), int(y - 0.5)
    f, g = x - 0.5 - i, y - 0.5 - j
    for a in range(2):
        for b in range(2):
            t = TEXELS * (i + a) + j + b
            if len(fragments):
                share = (f if a else 1.0 - f) * (g if b else 1.0 - g)
                fragments[ends[t], 0], fragments[ends[t], 1] = z, 1.0 - math.exp(-OPACITY * share * area)
            ends[t] += 1


@njit(cache=True, nogil=True, parallel=True)
def compress_all(starts: np.ndarray, fragments: np.ndarray, counts: np.ndarray, knots: np.ndarray) -> None:
    """Compress the fragments of every texel into knots from knots[2 starts[t]] on; `counts` gets their numbers."""
    for i in prange(TEXELS):
        for t in range(TEXELS * i, TEXELS * (i + 1)):
            counts[t] = 0
            if starts[t] < starts[t + 1]:
                own = fragments[starts[t] : starts[t + 1]]
                own = own[np.argsort(own[:, 0], kind="mergesort")]  # Stable: fragments at one depth keep their order.
                counts[t] = compress(own[:, 0], own[:, 1], TOLERANCE, knots[2 * starts[t] : 2 * starts[t + 1]])


@njit(cache=True, nogil=True)
def look_up_deep(starts: np.ndarray, knots: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return optical depths -log(transmittance) / OPACITY at places (n, 3) [texels], between the texels, (n,)."""
    taken = np.zeros(len(places))
    for p in range(len(places)):
        x = places[p, 0] - 0.5
        y = places[p, 1] - 0.5
        z = places[p, 2]
        if not (0.0 <= x < TEXELS - 1 and 0.0 <= y < TEXELS - 1):
            continue
        i, j = int(x), int(y)
        through = 0.0
        for a in range(2):
            for b in range(2):
                t = TEXELS * (i + a) + j + b
                share = (x - i if a else 1.0 - x + i) * (y - j if b else 1.0 - y + j)
                through += share * transmittance(knots, starts[t], starts[t + 1], z)  # Light adds up, depths do not.
        taken[p] = -math.log(max(through, LEAST)) / OPACITY
    return taken
