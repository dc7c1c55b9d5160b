"""Choose the cheapest combination of simplifications whose measured error is within the tolerance.

Errors do not add, so predictions only determine the next measurement, and every choice is measured.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from hairpipe.app.tune.measured import Measured
from hairpipe.values.simplification import Simplification

WORTH = 0.97
"""Largest ratio of times at which a simplification counts as a saving: times are measured no more accurately."""
MOST_TRIES = 12
"""Maximum number of measured combinations; then the best of them is chosen."""

Combination = frozenset[Simplification]
Measure = Callable[[Combination], Measured]


@dataclass(frozen=True)
class Guess:
    """The prediction for a combination before its measurement.

    bound    error if the contributions of its parts to the squared error of the full model add, in the tolerance's unit
    seconds  time if the savings of its parts multiply [s]
    """

    parts: Combination
    bound: float
    seconds: float


@dataclass(frozen=True)
class Trial:
    """A combination that was measured because of its prediction."""

    guess: Guess
    measured: Measured


@dataclass(frozen=True)
class Choice:
    """The choice.

    parts     simplifications of the choice; None if nothing satisfies the request
    measured  measurement of the choice, otherwise of the nearest: the full model, or the cheapest for a budget
    trials    measurements before the choice
    failed    combinations that are within the tolerance, but not in the check
    """

    parts: Combination | None
    measured: Measured
    trials: tuple[Trial, ...]
    failed: tuple[Combination, ...] = ()


def choose(
    full: Measured,
    singles: Mapping[Simplification, Measured],
    tolerance: float,
    measure: Measure,
    has_time: Callable[[], bool] = lambda: True,
    passes: Callable[[Combination], bool] = lambda parts: True,
) -> Choice:
    """Choose the cheapest combination within a tolerance.

    Those predicted within the tolerance are measured, the cheapest first, until one is within it; combinations that
    omit at least as much as a failed one are skipped. The cheapest of all measured within the tolerance is chosen that
    passes the check. None is chosen if the full model is not within it: a simplification that comes nearer does so by
    chance.

    has_time  whether another combination is measured after the first
    passes    whether a combination within the tolerance passes the check; the full model does
    """
    if not full.keeps(tolerance):
        return Choice(None, full, ())
    known = table_of(full, singles)
    useful = {part: found for part, found in singles.items() if found.keeps(tolerance)}
    guesses = sorted((g for g in guess_all(full, useful) if g.bound <= tolerance), key=by_cost)
    trials: list[Trial] = []
    failed: list[Combination] = []

    def holds(parts: Combination) -> bool:
        if any(leaves_out_as_much(parts, other) for other in failed):
            return False
        if not passes(parts):
            failed.append(parts)
        return parts not in failed

    for guess in guesses:
        if len(trials) == MOST_TRIES:
            break
        if guess.parts not in known:
            if trials and not has_time():
                break
            if any(leaves_out_as_much(guess.parts, other) for other in (*failed, *(t.guess.parts for t in trials))):
                continue
            known[guess.parts] = measure(guess.parts)
            trials.append(Trial(guess, known[guess.parts]))
        if known[guess.parts].keeps(tolerance) and holds(guess.parts):
            break
    within = [parts for parts, found in known.items() if found.keeps(tolerance) and saves_time(parts, found, full)]
    within.sort(key=lambda parts: (known[parts].seconds, *names(parts)))
    parts = next(parts for parts in within if not parts or holds(parts))
    return Choice(parts, known[parts], tuple(trials), tuple(failed))


def choose_within(
    full: Measured,
    singles: Mapping[Simplification, Measured],
    budget: float,
    measure: Measure,
    before: Iterable[Trial] = (),
) -> Choice:
    """Choose the combination of the smallest error that costs at most a budget [s] per frame.

    before  previous trials
    """
    known = table_of(full, singles) | {trial.guess.parts: trial.measured for trial in before}
    sound = {part: found for part, found in singles.items() if not found.fault}
    everything = list(guess_all(full, sound))
    guesses = sorted((g for g in everything if g.seconds <= budget), key=by_error) or [min(everything, key=by_cost)]
    trials: list[Trial] = []
    for guess in guesses[:MOST_TRIES]:
        if guess.parts not in known:
            known[guess.parts] = measure(guess.parts)
            trials.append(Trial(guess, known[guess.parts]))
        if known[guess.parts].seconds <= budget:
            break
    within = [parts for parts, found in known.items() if found.seconds <= budget and not found.fault]
    if not within:
        return Choice(None, min(known.values(), key=lambda found: found.seconds), tuple(trials))
    parts = min(within, key=lambda parts: (known[parts].bound, *names(parts)))
    return Choice(parts, known[parts], tuple(trials))


def table_of(full: Measured, singles: Mapping[Simplification, Measured]) -> dict[Combination, Measured]:
    known = {Combination(): full} | {Combination([part]): found for part, found in singles.items()}
    return {parts: found for parts, found in known.items() if not found.screened}


def guess_all(full: Measured, singles: Mapping[Simplification, Measured]) -> Iterator[Guess]:
    """Predict error and time of every combination of the simplifications that save time."""
    axes: dict[str, list[Simplification | None]] = {}
    for part, found in singles.items():
        if saves(part, found, full):
            axes.setdefault(part.axis, [None]).append(part)
    for picked in product(*axes.values()):
        taken = sorted(filter(None, picked), key=lambda part: part.axis)  # so that rounding is the same every time
        drops = [target for part in taken for target in part.drops]
        if len(drops) > len(set(drops)):
            continue  # a part can be omitted only once
        if any(p.compatible is not None and q.axis not in (p.axis, *p.compatible) for p in taken for q in taken):
            continue
        square = full.bound**2 + sum(max(singles[part].bound ** 2 - full.bound**2, 0.0) for part in taken)
        seconds = full.seconds * math.prod(min(singles[part].seconds / full.seconds, 1.0) for part in taken)
        yield Guess(Combination(taken), math.sqrt(square), seconds)


def saves(part: Simplification, found: Measured, full: Measured) -> bool:
    """Whether a simplification saves time, or drops physics that changes nothing: times of a busy machine are noisy."""
    idle = bool(part.drops) and found.bound <= full.bound
    return found.seconds <= WORTH * full.seconds or idle


def leaves_out_as_much(parts: Iterable[Simplification], other: Iterable[Simplification]) -> bool:
    """Whether a combination leaves out at least as much as another one, on every axis."""
    levels = {part.axis: part.level for part in parts}
    return all(levels.get(part.axis, 0) >= part.level for part in other)


def saves_time(parts: Combination, found: Measured, full: Measured) -> bool:
    return not parts or found.seconds <= WORTH * full.seconds


def by_cost(guess: Guess) -> tuple[float | str, ...]:
    """Order guesses by cost; of two with equal cost, the one that omits more is first."""
    return guess.seconds, -len(guess.parts), guess.bound, *names(guess.parts)


def by_error(guess: Guess) -> tuple[float | str, ...]:
    return guess.bound, guess.seconds, *names(guess.parts)


def names(parts: Iterable[Simplification]) -> list[str]:
    """List the parts that a combination omits, in a fixed order."""
    return sorted(f"{part.axis} {part.level}" for part in parts)
