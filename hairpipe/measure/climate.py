"""Errors of chaotic hair: of positions during the predictable frames, and of its climate afterwards."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.measure.distances import TESTED, Criteria, Run, observable_distances, position_squares
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
from hairpipe.values import Table
from hairpipe.values.table import table_of_columns

LEAST = 4
"""Fewest frames that define a climate."""
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
    frames = list(reference[0])
    seeds = sides.seeds[sides.model]
    lost = [(frame, seed) for run, seed in zip(model, seeds, strict=True) for frame in frames if frame not in run]
    if lost:
        failed = f"member {min(lost)[1]} not finite at frame {min(lost)[0]}"
        return _table({name: np.inf for name in (*ERRORS[:-1], *BIASES[:-1])}, "", failed)
    if len(frames) < 2:
        raise BadInput("a single frame", where="frames", right="at least two: nothing has moved at the first")
    frames = frames[1:]
    runs = [*model, *reference]
    squares = position_squares(runs, frames, criteria.patches)
    whole = squares.mean(axis=1)
    spreads = np.array([_spread(matrix, sides) for matrix in whole])
    count = min(criteria.predicted or predictable(spreads, criteria.tolerance), len(frames))
    floor = _spread(whole[:count].mean(axis=0), sides)
    if half:
        pairs = [position_squares(pair, frames[:count], 1) for pair in zip(half, reference, strict=False)]
        floor = np.sqrt(np.mean([matrix[..., 0, 1] for matrix in pairs]))
    found = {"predicted [s]": count / criteria.fps}
    found |= zip(ERRORS, (*_roots(paired(squares[:count].mean(axis=0), sides)), floor), strict=True)
    if count < len(frames):
        found |= _afterwards(squares[count:].mean(axis=0), sides)
    if count + LEAST <= len(frames):
        seen = look(observable_distances(runs, frames[count:], criteria), sides)
        found |= zip(LOOKS, (seen.score, seen.p, *seen.ratios), strict=True)
    return _table(found, describe_chaos(frames, count, spreads, criteria.tolerance), "")


def predictable(spreads: np.ndarray, tolerance: float) -> int:
    """Return the number of frames for which the spread of the reference [%], (frames,), is at most half the tolerance.

    Raises BadInput if there are none.
    """
    count = frames_within(spreads, 50.0 * tolerance)
    if not count:
        what = f"members of the reference are {spreads[0]:.2g} % of their length apart at the first frame"
        right = f"more than {0.02 * spreads[0]:.2g}, or members that differ by less"
        raise BadInput(what, where="tolerance", right=right)
    return count


def describe_chaos(frames: Sequence[int], count: int, spreads: np.ndarray, tolerance: float) -> str:
    """Describe whether hair with so many predictable frames is chaotic, and why."""
    apart = f"two references are at most {spreads.max():.2g} % of length apart, {50.0 * tolerance:.2g} % is allowed"
    if count == len(frames):
        return f"none: {apart}"
    short = ", and too few frames remain to compare statistics" if len(frames) - count < LEAST else ""
    return f"from frame {frames[count]} on: {apart}{short}"


def paired(squares: np.ndarray, sides: Sides) -> Interval:
    """Return the mean square of equal seeds, of squares (patches, K, K), and its interval by patches, or by seeds.

    BadInput where there are none.
    """
    pairs = [np.flatnonzero(sides.seeds == seed) for seed in sides.seeds[sides.model]]
    found = [squares[:, pair[0], pair[1]] for pair in pairs if len(pair) == 2]
    if not found:
        raise BadInput("no member is on both sides", where="members", right="member 0 on both, at least")
    return interval_of_samples(np.mean(found, axis=0) if len(squares) > 1 else np.ravel(found))


def bias(squares: np.ndarray, sides: Sides) -> Interval:
    """Return B^2 of squares, (patches, K, K), and its interval by patches, or by members where there is one patch."""
    if len(squares) > 1:
        return interval_of_samples(squared_bias(np.sqrt(squares), sides))
    return interval_by_members(np.sqrt(squares[0]), sides)


def _afterwards(squares: np.ndarray, sides: Sides) -> dict[str, float]:
    """Return bias, its floor and the ratio of spreads, of squares (patches, K, K)."""
    distances = np.sqrt(squares.mean(axis=0))
    floor = signed_root(floors(distances, sides, squared_bias))
    found = dict(zip(BIASES, (*_roots(bias(squares, sides)), float(floor)), strict=True))
    return found | {"spread": float(spread_ratio(distances, sides))}


def _spread(squares: np.ndarray, sides: Sides) -> float:
    """Return the root mean square distance of two members of the reference."""
    return float(root_mean_square(squares[np.ix_(~sides.model, ~sides.model)]))


def _roots(interval: Interval) -> list[float]:
    """Return the roots of an interval of squares, with their sign."""
    return signed_root(np.array(interval)).tolist()


def _table(found: Mapping[str, Any], chaos: str, failed: str) -> Table:
    """Make the row of the values that were found; the others are NaN."""
    numbers = {name: [found.get(name, np.nan)] for name in NUMBERS}
    return table_of_columns({**numbers, "chaos": [chaos], "failed": [failed]})
