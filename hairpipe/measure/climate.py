"""Errors of chaotic hair: of positions during the predictable frames, and of its climate afterwards."""

from collections.abc import Sequence
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
