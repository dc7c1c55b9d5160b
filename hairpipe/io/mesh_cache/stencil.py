"""Interpolation of samples in time: weights of the samples around an instant.

Between two samples points follow the cubic through both with the velocities there (Hermite). Velocities are those of
the file or, without any, the slope of the parabola through three samples: those before, at and after a sample, and the
nearest three at a cut and at an end. A value depends on two samples to either side of its instant, and on no others.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput

SLACK = 1e-3
"""Distance from a sample at which an instant is the sample, as a share of the interval: files round their times."""


class Stencil(NamedTuple):
    """Linear combination of samples: points and velocities at an instant.

    samples  indices, (k,) int64
    weights  of the points [1] and velocities [s] of the samples in the points, and in the velocities [1/s], [1],
             (k, 2, 2) float64: [sample, in points or velocities, of points or velocities]
    """

    samples: np.ndarray
    weights: np.ndarray


class Take(NamedTuple):
    """Samples between which points move without a jump.

    first, last    both included
    opens, closes  whether there is a cut before the first, and after the last
    """

    first: int
    last: int
    opens: bool
    closes: bool


def take_at(times: np.ndarray, at: float, cuts: Sequence[tuple[float, float]]) -> Take:
    """Return the samples of the take that holds an instant; pure.

    times  of the samples, ascending [s], (n,)
    cuts   instants of the last frame before each cut and of the first one after it, ascending [s]; samples between the
           two belong to neither take

    Raises BadInput where a take has no sample.
    """
    starts = [after - SLACK * (after - before) for before, after in cuts if after <= at]
    ends = [before + SLACK * (after - before) for before, after in cuts if after > at]
    first = int(np.searchsorted(times, max(starts, default=-np.inf), side="left"))
    last = int(np.searchsorted(times, min(ends, default=np.inf), side="right")) - 1
    if first > last:
        what = f"the file has no sample between the two cuts around {at:.3f} s"
        raise BadInput(what, where="cuts", right="one sample or more between two cuts")
    return Take(first, last, first > 0, last < len(times) - 1)


def stencil_at(times: np.ndarray, at: float, cuts: Sequence[tuple[float, float]], own: bool) -> Stencil:
    """Return the weights of the samples at an instant; pure.

    Outside of the samples their ends hold still. At a cut, motion goes on as at the last sample of the take.

    times, cuts  as of `take_at`
    own          whether samples have velocities; next to a cut they are not used, since programs compute them over it
    """
    take = take_at(times, at, cuts)
    held = times[take.first : take.last + 1]
    place = min(max(int(np.searchsorted(held, at, side="right")) - 1, 0), max(len(held) - 2, 0))
    span = float(np.diff(held[place : place + 2]).sum()) or 1.0
    share = (at - held[place]) / span
    nearest = place + round(share) if len(held) > 1 else place
    table = _Table()
    here = take.first + place
    if nearest in (place, place + 1) and abs(at - held[nearest]) <= SLACK * span:
        table.add(take.first + nearest, np.array([1.0, 0.0]))
        table.add_slope(times, take, take.first + nearest, own, np.array([0.0, 1.0]))
    elif 0.0 < share < 1.0 and len(held) > 1:
        square = share * share
        cube = square * share
        table.add(here, np.array([2.0 * cube - 3.0 * square + 1.0, 6.0 * (square - share) / span]))
        table.add(here + 1, np.array([3.0 * square - 2.0 * cube, 6.0 * (share - square) / span]))
        slope = np.array([(cube - 2.0 * square + share) * span, 3.0 * square - 4.0 * share + 1.0])
        table.add_slope(times, take, here, own, slope)
        table.add_slope(times, take, here + 1, own, np.array([(cube - square) * span, 3.0 * square - 2.0 * share]))
    else:
        end, is_cut = (take.first, take.opens) if share <= 0.0 else (take.last, take.closes)
        table.add(end, np.array([1.0, 0.0]))
        if is_cut:
            table.add_slope(times, take, end, own, np.array([at - times[end], 1.0]))
    return table.stencil()


class _Table:
    """Sums of weights by sample."""

    def __init__(self) -> None:
        self.weights: dict[int, np.ndarray] = {}

    def add(self, sample: int, weights: np.ndarray, kind: int = 0) -> None:
        """Add weights (2,) in the points and velocities, of the points (0) or velocities (1) of a sample, in place."""
        self.weights.setdefault(sample, np.zeros((2, 2)))[:, kind] += weights

    def add_slope(self, times: np.ndarray, take: Take, sample: int, own: bool, weights: np.ndarray) -> None:
        """Add weights (2,) of the velocity at a sample, in place."""
        at_cut = (sample == take.first and take.opens) or (sample == take.last and take.closes)
        if own and not at_cut:
            self.add(sample, weights, 1)
            return
        first = max(min(sample - 1, take.last - 2), take.first)
        around = range(first, min(first + 2, take.last) + 1)
        for one, slope in zip(around, slopes(times[first : around[-1] + 1], times[sample]), strict=True):
            self.add(one, slope * weights)

    def stencil(self) -> Stencil:
        """Return the sums in the order of the samples."""
        samples = sorted(self.weights)
        return Stencil(np.array(samples), np.array([self.weights[sample] for sample in samples]))


def slopes(times: np.ndarray, at: float) -> np.ndarray:
    """Return the weights of values in the slope at an instant of the polynomial through them, (n,); pure.

    times  of the values, one to three [s], (n,)
    """
    powers = np.arange(len(times))
    ahead = np.vander(times - at, increasing=True)
    return np.linalg.solve(ahead.T, (powers == 1).astype(float)) if len(times) > 1 else np.zeros(1)
