"""Errors of chaotic hair: of positions during the predictable frames, and of its climate afterwards.

Observables of chaotic hair, position, volume, motion and stretch, do not refer to single strands: each is a function of
the visible strands, so that it compares any two models of hair. All are pure.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.measure.contact import at_levels, nearest, touching
from hairpipe.measure.deviation import deviation, patches_of
from hairpipe.measure.ensemble import (
    Interval,
    Sides,
    floors,
    frames_within,
    interval_by_members,
    interval_of_samples,
    look,
    root_mean_square,
    signed_root,
    spread_ratio,
    squared_bias,
)
from hairpipe.values import Strands, Table
from hairpipe.values.groom import lengths_at_points, segment_lengths, strand_lengths
from hairpipe.values.strand_arrays import at_shares, shares_of
from hairpipe.values.table import table_of_columns

SHARES = np.linspace(0.2, 1.0, 5)  # shares of the length at which strands are sampled
CELL, PIXEL = 0.02, 0.002  # side of the cubes in which hair is counted, and of the pixels of silhouettes [m]
STRAIN = 0.95  # quantile of strain: a lower one is noise, a higher one is of a few segments
STILL = 1e-12  # power of speed that is treated as zero [m^2/s^2]


def resampled(hair: Strands, offsets: np.ndarray) -> Strands:
    """Return hair resampled to these offsets, at equal shares of the lengths; ValueError for another number."""
    if np.array_equal(hair.offsets, offsets):
        return hair
    if len(hair.offsets) != len(offsets):
        raise ValueError(f"{len(hair.offsets) - 1} strands against {len(offsets) - 1}")
    points, velocities = (
        at_shares(values.astype(float), hair.offsets, *shares_of(offsets)) for values in (hair.points, hair.velocities)
    )
    return Strands(points, velocities.astype(np.float32), offsets, hair.diameter)


def wasserstein(one: np.ndarray, other: np.ndarray) -> float:
    """Return the mean, over shares and axes, of Wasserstein-1 distances of strands at shares, (shares, S, 3) [m]."""
    from scipy.stats import wasserstein_distance

    pairs = [(a[:, axis], b[:, axis]) for a, b in zip(one, other, strict=True) for axis in range(3)]
    return float(np.mean([wasserstein_distance(*pair) for pair in pairs]))


def places(hair: Strands) -> np.ndarray:
    """Return the position of every strand at the shares of its length [m], (shares, S, 3)."""
    return at_levels(hair, SHARES)


def kinetic_energy(hair: Strands, gravity: float) -> float:
    """Return the kinetic energy over m g L, the mean over strands; mass is even along a strand."""
    masses = lengths_at_points(hair.points.astype(float), hair.offsets)
    energies = np.add.reduceat(0.5 * masses * np.sum(hair.velocities.astype(float) ** 2, axis=1), hair.offsets[:-1])
    return float(np.mean(energies / (gravity * strand_lengths(hair.points, hair.offsets) ** 2)))


def log_spectrum(speeds: np.ndarray, fps: float) -> np.ndarray:
    """Return the logarithm of the power of speeds, (frames, S), at each frequency but 0, the mean over strands."""
    from scipy.signal import periodogram

    _, power = periodogram(speeds, fps, scaling="spectrum", axis=0)
    return np.log(power[1:].mean(axis=1) + STILL)


def tip_speeds(hair: Strands) -> np.ndarray:
    """Return the speed of every tip [m/s], (S,)."""
    return np.linalg.norm(hair.velocities[hair.offsets[1:] - 1].astype(float), axis=1)


def contacts(hair: Strands, reach: float) -> float:
    """Return the number of points of other strands within reach [m] of a point, the mean over all but the roots."""
    return 2.0 * len(touching(hair, reach)) / (len(hair.points) - len(hair.offsets) + 1)


def strain(hair: Strands, rest: np.ndarray) -> float:
    """Return the 95 % quantile of |strain| over all segments, of lengths at rest [m], (P - S,)."""
    return float(np.quantile(np.abs(segment_lengths(hair.points, hair.offsets) / rest - 1.0), STRAIN))


def density(hair: Strands, cell: float = CELL) -> tuple[np.ndarray, np.ndarray]:
    """Return the cubes that contain hair, and the share of hair in each: keys, ascending, and shares, (n,)."""
    points, lengths = _samples(hair, cell)
    keys, where = np.unique(_keys(points / cell), return_inverse=True)
    return keys, np.bincount(where.ravel(), lengths) / lengths.sum()


def density_distance(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> float:
    """Return the share of hair in other cubes, half of the L1 distance of two densities, 0..1."""
    keys, shares = (np.concatenate(pair) for pair in ((one[0], other[0]), (one[1], -other[1])))
    where = np.unique(keys, return_inverse=True)[1].ravel()
    return 0.5 * float(np.abs(np.bincount(where, shares)).sum())


def silhouettes(hair: Strands, pixel: float = PIXEL) -> list[np.ndarray]:
    """Return the pixels that hair covers, seen along each axis: keys, ascending, one array a view."""
    points = np.floor(_samples(hair, pixel)[0] / pixel)
    return [np.unique(_keys(np.delete(points, axis, axis=1))) for axis in range(3)]


def silhouette_distance(one: list[np.ndarray], other: list[np.ndarray]) -> float:
    """Return sqrt(1 - IoU), intersection over union of silhouettes, the mean over the views."""
    # The square root makes it a distance of negative type: its energy distance is 0 only for equal distributions.
    common = [len(np.intersect1d(*views, assume_unique=True)) for views in zip(one, other, strict=True)]
    whole = [len(a) + len(b) - both for a, b, both in zip(one, other, common, strict=True)]
    return float(np.mean(np.sqrt(1.0 - np.divide(common, whole))))


def _samples(hair: Strands, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places along all segments, no farther apart than half the spacing [m], (n, 3), and the length of each."""
    points = hair.points.astype(float)
    first = np.delete(np.arange(len(hair.points)), hair.offsets[1:] - 1)
    lengths = segment_lengths(hair.points, hair.offsets)
    pieces = max(int(np.ceil(2.0 * lengths.max() / spacing)), 1)
    shares = ((np.arange(pieces) + 0.5) / pieces)[:, None, None]
    found = (1.0 - shares) * points[first] + shares * points[first + 1]
    return found.reshape(-1, 3), np.tile(lengths / pieces, pieces)


def _keys(cells: np.ndarray) -> np.ndarray:
    """Return one number for each cell of a grid that holds a place, (n, 2) or (n, 3), within a million cells of 0."""
    keys = np.zeros(len(cells), np.int64)
    for column in np.floor(cells).astype(np.int64).T:
        keys = (keys << 21) + column + (1 << 20)
    return keys


Run = Mapping[int, Strands]


class Criteria(NamedTuple):
    """Criteria of comparison."""

    tolerance: float  # of points, over the length of their strands
    patches: int  # number of patches of consecutive strands, as equal as possible
    reach: float  # distance up to which two points touch [m]
    gravity: float  # scale of energy [m/s^2]
    fps: float  # frames per second [1/s]
    predicted: int | None = None  # number of predictable frames after the first; None: found by the tolerance


def _apart(one: Any, other: Any) -> float:
    """Return the distance of two numbers, or the mean distance of those of two arrays."""
    return float(np.mean(np.abs(one - other)))


OBSERVABLES: Mapping[str, Callable[[Any, Any], float]] = {
    "position": wasserstein,
    "density": density_distance,
    "silhouettes": silhouette_distance,
    "nearest strand": _apart,
    "contacts": _apart,
    "kinetic energy": _apart,
    "strain": _apart,
}
"""Observables of a frame, and their distances between two runs."""
TESTED = (*OBSERVABLES, "speed spectrum")
"""The same, and the observables of all frames together."""


def position_squares(runs: Sequence[Run], frames: Sequence[int], patches: int) -> np.ndarray:
    """Return mean squares of the distances of points of two runs, over their length [%^2], (frames, patches, K, K).

    Runs are compared at the points of the last run. Raises BadInput if strands do not correspond.
    """
    found = np.zeros((len(frames), patches, len(runs), len(runs)))
    for row, frame in zip(found, frames, strict=True):
        hairs = _hairs(runs, frame)
        count = len(hairs[0].offsets) - 1
        if count < patches:
            raise BadInput(f"{count} strands in {patches} patches", where="patches", right="fewer")
        for matrix, *parts in zip(row, *(patches_of(hair, patches) for hair in hairs), strict=True):
            matrix[:] = _matrix(parts, lambda one, other: deviation(one, other).whole_percent ** 2)
    return found


def observable_distances(runs: Sequence[Run], frames: Sequence[int], criteria: Criteria) -> np.ndarray:
    """Return distances of runs in every observable, means over the frames, (Q, K, K) in the order of `TESTED`."""
    firsts = [run[next(iter(run))] for run in runs]
    rests = [segment_lengths(hair.points, hair.offsets) for hair in firsts]
    total = np.zeros((len(OBSERVABLES), len(runs), len(runs)))
    speeds = []
    for frame in frames:
        hairs = _hairs(runs, frame)
        speeds.append([tip_speeds(hair) for hair in hairs])
        values = {
            "position": [places(hair) for hair in hairs],
            "density": [density(hair) for hair in hairs],
            "silhouettes": [silhouettes(hair) for hair in hairs],
            "nearest strand": [nearest(places(hair)) for hair in hairs],
            "contacts": [contacts(hair, criteria.reach) for hair in hairs],
            "kinetic energy": [kinetic_energy(hair, criteria.gravity) for hair in hairs],
            "strain": [strain(run[frame], rest) for run, rest in zip(runs, rests, strict=True)],
        }
        total += [_matrix(values[name], apart) for name, apart in OBSERVABLES.items()]
    spectra = [log_spectrum(np.array(series), criteria.fps) for series in zip(*speeds, strict=True)]
    spread = _matrix(spectra, lambda one, other: float(np.sqrt(np.mean((one - other) ** 2))))
    return np.concatenate([total / len(frames), [spread]])


def _hairs(runs: Sequence[Run], frame: int) -> list[Strands]:
    """Return the hair of all runs at a frame, resampled to the points of the last run."""
    hairs = [run[frame] for run in runs]
    try:
        return [resampled(hair, hairs[-1].offsets) for hair in hairs]
    except ValueError as wrong:
        raise BadInput(f"members do not correspond: {wrong}", where="in.hair", right="the same strands") from None


def _matrix(values: Sequence[Any], apart: Callable[[Any, Any], float]) -> np.ndarray:
    """Return the distances of all values, (K, K)."""
    found = np.zeros((len(values), len(values)))
    for one in range(len(values)):
        for other in range(one):
            found[one, other] = found[other, one] = apart(values[one], values[other])
    return found


LEAST = 4  # fewest frames that define a climate
ERRORS = tuple(f"{name} [% of length]" for name in ("error", "low", "high", "floor"))
BIASES = tuple(f"bias{name} [% of length]" for name in ("", " low", " high", " floor"))
LOOKS = ("Z", "p", *(f"{name} T/F" for name in TESTED))
NUMBERS = (*ERRORS, "predicted [s]", *BIASES, "spread", *LOOKS)


def climate_table(
    model: Sequence[Run], reference: Sequence[Run], half: Sequence[Run], sides: Sides, criteria: Criteria
) -> Table:
    """Return one row: differences of members of a model from those of a reference; the first frame is excluded.

    half   members of the reference at half its step, with the seeds of its first members
    sides  of the members, those of the model first

    error      in the predictable frames, root mean square of equal seeds over points and frames
    floor      of the error: difference of the reference and its half, or without, of two members of the reference
    predicted  predictable time since the first frame
    bias       afterwards: difference of the means of both sides (`squared_bias`), with its sign, and its floor F
    low, high  90 % intervals: by patches, or with one patch by seeds and members
    spread     afterwards, over that of the reference
    Z, p, T/F  afterwards, of the observables (`look`)
    The later values are NaN without later frames. Where a member is not finite at some frame, errors are infinite.
    BadInput where strands do not correspond, no seed is on both sides, or members of the reference differ by more
    than half the tolerance at the start.
    """
    row: dict[str, Any] = {**dict.fromkeys(NUMBERS, np.nan), "chaos": "", "failed": ""}
    frames = list(reference[0])
    seeds = sides.seeds[sides.model]
    lost = [(frame, seed) for run, seed in zip(model, seeds, strict=True) for frame in frames if frame not in run]
    if lost:
        row |= dict.fromkeys((*ERRORS[:-1], *BIASES[:-1]), np.inf)
        row["failed"] = f"member {min(lost)[1]} not finite at frame {min(lost)[0]}"
        return table_of_columns({name: [value] for name, value in row.items()})
    if len(frames) < 2:
        raise BadInput("a single frame", where="frames", right="at least two: nothing has moved at the first")
    frames = frames[1:]
    runs = [*model, *reference]
    squares = position_squares(runs, frames, criteria.patches)
    whole = squares.mean(axis=1)
    others = np.ix_(~sides.model, ~sides.model)
    spreads = np.array([float(root_mean_square(matrix[others])) for matrix in whole])
    allowed = 50.0 * criteria.tolerance  # half the tolerance [%]
    count = min(criteria.predicted or frames_within(spreads, allowed), len(frames))
    if not count:
        what = f"members of the reference are {spreads[0]:.2g} % of their length apart at the first frame"
        right = f"more than {0.02 * spreads[0]:.2g}, or members that differ by less"
        raise BadInput(what, where="tolerance", right=right)
    floor = float(root_mean_square(whole[:count].mean(axis=0)[others]))
    if half:
        pairs = [position_squares(pair, frames[:count], 1) for pair in zip(half, reference, strict=False)]
        floor = np.sqrt(np.mean([matrix[..., 0, 1] for matrix in pairs]))
    row["predicted [s]"] = count / criteria.fps
    errors = signed_root(np.array(paired(squares[:count].mean(axis=0), sides))).tolist()
    row |= zip(ERRORS, (*errors, floor), strict=True)
    if count < len(frames):
        later = squares[count:].mean(axis=0)
        distances = np.sqrt(later.mean(axis=0))
        if len(later) > 1:
            bias = interval_of_samples(squared_bias(np.sqrt(later), sides))
        else:
            bias = interval_by_members(np.sqrt(later[0]), sides)
        least = float(signed_root(floors(distances, sides, squared_bias)))
        row |= zip(BIASES, (*signed_root(np.array(bias)).tolist(), least), strict=True)
        row["spread"] = float(spread_ratio(distances, sides))
    if count + LEAST <= len(frames):
        seen = look(observable_distances(runs, frames[count:], criteria), sides)
        row |= zip(LOOKS, (seen.score, seen.p, *seen.ratios), strict=True)
    apart = f"two references are at most {spreads.max():.2g} % of length apart, {allowed:.2g} % is allowed"
    short = ", and too few frames remain to compare statistics" if len(frames) - count < LEAST else ""
    row["chaos"] = f"none: {apart}" if count == len(frames) else f"from frame {frames[count]} on: {apart}{short}"
    return table_of_columns({name: [value] for name, value in row.items()})


def paired(squares: np.ndarray, sides: Sides) -> Interval:
    """Return the mean square of equal seeds, of squares (patches, K, K), and its interval by patches, or by seeds."""
    pairs = [np.flatnonzero(sides.seeds == seed) for seed in sides.seeds[sides.model]]
    found = [squares[:, pair[0], pair[1]] for pair in pairs if len(pair) == 2]
    if not found:
        raise BadInput("no member is on both sides", where="members", right="member 0 on both, at least")
    return interval_of_samples(np.mean(found, axis=0) if len(squares) > 1 else np.ravel(found))
