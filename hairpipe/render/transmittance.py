"""Transmittance along a ray through translucent media: exact, compressed, and evaluated.

Transmittance along a ray is a step function of depth: the product of (1 - opacity) of all fragments in front. It is
compressed to a piecewise linear function within a tolerance of the steps, with two knots at one depth for a jump
(Lokovic and Veach 2000, Sec. 3.2: each vertex narrows the interval of slopes from the last knot, until it is empty).
"""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def compress(depths: np.ndarray, opacities: np.ndarray, tolerance: float, knots: np.ndarray) -> int:
    """Compress the transmittance behind n fragments into at most 2 n knots, and return their number.

    depths     of the fragments, ascending, (n,)
    opacities  0 to 1, (n,)
    tolerance  largest error of the result
    knots      depth and transmittance, not increasing, (2 n, 2) float32, written
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
