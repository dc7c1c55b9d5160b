"""Tune a scene: choose a sample, measure error and time of each simplification, and choose a combination.

The cheapest combination is chosen whose error is within the tolerance. Errors do not add, so predictions only determine
the next measurement, and every choice is measured.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from hairpipe.app.tune.measured import INDIFFERENT, LEAST, Chaos, Measured, Results, Tolerance
from hairpipe.app.tune.sampling import PATCHES, STILL, RootMotion, Sample, choose_sample, hardest, other_sample
from hairpipe.app.tune.simplifications import model_in, simplifications, touches
from hairpipe.app.tune.study import Interrupted, Request, Study, with_node
from hairpipe.errors import BadInput
from hairpipe.values import Groom
from hairpipe.values.groom import strand_lengths
from hairpipe.values.simplification import Simplification

WORTH = 0.97
"""Largest ratio of times at which a simplification counts as a saving: times are measured no more accurately."""
MOST_TRIES = 12  # maximum number of measured combinations; then the best of them is chosen
CHECKS = 2  # number of further samples on which a choice is checked: errors of few strands and frames vary

Combination = frozenset[Simplification]
Measure = Callable[[Combination], Measured]


@dataclass(frozen=True)
class Guess:
    """The prediction for a combination before its measurement."""

    parts: Combination
    bound: float  # error, in the tolerance's unit, if the squared errors that its parts add to the full model's add up
    seconds: float  # time if the savings of its parts multiply [s]


class Trial(NamedTuple):
    """A combination that was measured because of its prediction."""

    guess: Guess
    measured: Measured


@dataclass(frozen=True)
class Choice:
    """The choice.

    measured  measurement of the choice, otherwise of the nearest: the full model, or the cheapest for a budget
    """

    parts: Combination | None  # simplifications of the choice; None if nothing satisfies the request
    measured: Measured
    trials: tuple[Trial, ...]  # measurements before the choice
    failed: tuple[Combination, ...] = ()  # combinations that are within the tolerance, but not in a check


def choose(
    full: Measured,
    singles: Mapping[Simplification, Measured],
    tolerance: float,
    measure: Measure,
    has_time: Callable[[], bool] = lambda: True,
    passes: Callable[[Combination], bool] = lambda parts: True,
) -> Choice:
    """Choose the cheapest of the combinations measured within a tolerance that passes the check; the full model does.

    Those predicted within the tolerance are measured, the cheapest first, until one is within it, after the first only
    while there is time; combinations that omit at least as much as a failed one are skipped.
    """
    if not full.keeps(tolerance):  # a simplification that comes nearer does so by chance
        return Choice(None, full, ())
    known = measured_at_first(full, singles)
    useful = {part: found for part, found in singles.items() if found.keeps(tolerance)}
    guesses = sorted((guess for guess in guess_all(full, useful) if guess.bound <= tolerance), key=by_cost)
    trials: list[Trial] = []
    failed: list[Combination] = []

    def exceeds(parts: Combination, others: Iterable[Combination]) -> bool:
        return any(leaves_out_as_much(parts, other) for other in others)

    def holds(parts: Combination) -> bool:
        if exceeds(parts, failed):
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
            if exceeds(guess.parts, (*failed, *(trial.guess.parts for trial in trials))):
                continue
            known[guess.parts] = measure(guess.parts)
            trials.append(Trial(guess, known[guess.parts]))
        if known[guess.parts].keeps(tolerance) and holds(guess.parts):
            break
    dearest = WORTH * full.seconds
    within = [p for p, found in known.items() if found.keeps(tolerance) and (not p or found.seconds <= dearest)]
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
    """Choose the combination of the smallest error that costs at most a budget [s] per frame, after earlier trials."""
    known = measured_at_first(full, singles) | {trial.guess.parts: trial.measured for trial in before}
    everything = list(guess_all(full, {part: found for part, found in singles.items() if not found.fault}))
    cheap = [guess for guess in everything if guess.seconds <= budget]
    cheap.sort(key=lambda guess: (guess.bound, guess.seconds, *names(guess.parts)))
    trials: list[Trial] = []
    for guess in (cheap or [min(everything, key=by_cost)])[:MOST_TRIES]:
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


def measured_at_first(full: Measured, singles: Mapping[Simplification, Measured]) -> dict[Combination, Measured]:
    """List the initial measurements by combination, without those that were screened only."""
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


def by_cost(guess: Guess) -> tuple[float | str, ...]:
    """Order guesses by cost; of two with equal cost, the one that omits more is first."""
    return guess.seconds, -len(guess.parts), guess.bound, *names(guess.parts)


def names(parts: Iterable[Simplification]) -> list[str]:
    """List the parts that a combination omits, in a fixed order."""
    return sorted(f"{part.axis} {part.level}" for part in parts)


ROOTS = "tune-roots"
SHARE, LEAST_TIME = 0.1, 600.0
"""Time after which no other model is measured: a share of that of the shot's own simulation, and a minimum [s]."""
AT_ONCE = 4  # number of models whose members are simulated between two looks at the time


class Untunable(BadInput):
    """The unchanged graph, or its reference, fails on the sample."""


@dataclass(frozen=True)
class Check:
    """The choice, measured on strands and frames outside the other samples, if the scene has any."""

    sample: Sample
    reference: Measured | Chaos  # as in `Tuned`
    full: Measured
    chosen: Measured


@dataclass(frozen=True)
class Tuned:
    """The results of tuning."""

    strands: int  # number of strands of the scene
    sample: Sample
    tolerance: Tolerance
    reference: Measured | Chaos  # change of its tips when its steps were halved, or where hair acts on hair, its chaos
    steps: str  # steps of the reference, in words
    full: Measured  # measurement of the unchanged graph
    singles: dict[Simplification, Measured]  # each simplification on its own
    choice: Choice
    budget: float | None = None  # requested processor time of a frame [s]
    affordable: Choice | None = None  # choice within the budget, where the choice for the tolerance costs more
    checks: tuple[Check, ...] = ()  # none where none was requested, or nothing was chosen
    stopped: float | None = None  # processor time after which nothing else was measured [s]; None: it was enough
    motion: RootMotion = STILL  # hardest motion of the shot: the promise holds for motions that are no harder

    @property
    def kept(self) -> bool:
        """Whether the error is within the tolerance, also in the checks."""
        return self.choice.parts is not None and all(check.chosen.kept(self.tolerance.value) for check in self.checks)


class Scene(NamedTuple):
    """Properties of a scene before the simulation."""

    strands: int
    motion: np.ndarray | None  # acceleration of the roots [m/s^2], (frames,); None if no root moves
    tip: float | None  # initial difference of members of an ensemble [m]; None without chaos, and where tips are held
    hardest: RootMotion = STILL


def tune(request: Request, echo: Callable[[str], None] = lambda line: None) -> Tuned:
    """Measure strands and frames of a scene, and choose; raises BadInput if the graph cannot be tuned.

    echo  receives a line about each measurement
    """
    if len(request.shot.frames) < 2:
        raise BadInput(
            "a motion needs two frames or more", where=request.shot.path, right="frames = [first, last] farther apart"
        )
    with request.shot.keeping_workers() as shot:
        return measured_and_chosen(replace(request, shot=shot), echo)


def measured_and_chosen(request: Request, echo: Callable[[str], None]) -> Tuned:
    """Measure the unchanged graph and each simplification, and choose; as `tune`, with persistent workers."""
    shot = request.shot
    tolerance = request.tolerance.value
    listed = simplifications(shot.graph, request.hair)
    scene = look_at(request)
    sample = sample_of(request, scene)
    study = Study(request, sample, scene.strands, scene.tip)
    echo(described(sample, scene.strands))
    reference = study.converged()
    full = study.measure_all([[]])[0]
    fault = full.fault or (reference.fault if isinstance(reference, Measured) else "")
    if fault:
        raise Untunable(f"the unchanged graph fails on the sample: {fault}", where=shot.path)
    study.limit = request.time or max(SHARE * full.seconds * len(shot.frames), LEAST_TIME)
    singles = measured_singles(study, [part for part in listed if part.count <= scene.strands])
    if full.screened:
        full, screened = study.confirm([]), full
        if full.keeps(tolerance):
            worthy = [
                part for part, found in singles.items() if found.keeps(tolerance) and saves(part, found, screened)
            ]
            worthy.sort(key=lambda part: singles[part].seconds)
            for some in (worthy[at : at + AT_ONCE] for at in range(0, len(worthy), AT_ONCE)):
                if study.has_time():
                    singles |= zip(some, study.confirm_all([part] for part in some), strict=True)
    samples = [sample]
    for _ in range(CHECKS if request.check else 0):
        samples.append(other_sample(samples, shot.frames, shot.fps, scene.motion, scene.strands))
    others = [Checking(request, other, scene, echo) for other in samples[1:]]
    choice = choose(
        full, singles, tolerance, study.confirm, study.has_time, lambda parts: all(one.passes(parts) for one in others)
    )
    stopped = study.limit if study.stopped else None
    affordable = None
    if request.budget is not None and (choice.parts is None or choice.measured.seconds > request.budget):
        affordable = choose_within(full, singles, request.budget, study.confirm, choice.trials)
    return Tuned(
        scene.strands,
        sample,
        request.tolerance,
        reference,
        study.steps,
        full,
        singles,
        choice,
        request.budget,
        affordable,
        tuple(other.check(choice.parts) for other in others) if choice.parts is not None else (),
        stopped,
        scene.hardest,
    )


def measured_singles(study: Study, parts: Sequence[Simplification]) -> dict[Simplification, Measured]:
    """Measure simplifications on their own while there is time: the first of every axis side by side, then the next."""
    found: dict[Simplification, Measured] = {}
    for level in sorted({part.level for part in parts}):
        some = [part for part in parts if part.level == level]
        if study.has_time():
            found |= zip(some, study.measure_all([part] for part in some), strict=True)
    return {part: found[part] for part in parts if part in found}


def sample_of(request: Request, scene: Scene) -> Sample:
    """Choose strands and frames; strands have their neighbours where hair acts on hair."""
    shot = request.shot
    patches = PATCHES if touches(shot.graph.node(request.hair)) else request.strands
    return choose_sample(shot.frames, shot.fps, scene.motion, scene.strands, request.strands, patches)


class Checking:
    """Measurements on another sample; nothing is measured before the first."""

    def __init__(self, request: Request, sample: Sample, scene: Scene, echo: Callable[[str], None]) -> None:
        self._study = Study(request, sample, scene.strands, scene.tip)
        self._sample, self._scene, self._echo = sample, scene, echo
        self._tolerance = request.tolerance.value
        self._reference: Measured | Chaos | None = None

    def check(self, parts: Combination) -> Check:
        if self._reference is None:
            self._echo(f"check: {described(self._sample, self._scene.strands)}")
            self._reference = self._study.converged()
        return Check(self._sample, self._reference, *self._study.confirm_all([[], parts]))

    def passes(self, parts: Combination) -> bool:
        """Whether a choice keeps the tolerance here; where the unchanged graph does not, none can, and all pass."""
        found = self.check(parts)
        return found.chosen.kept(self._tolerance) or not found.full.kept(self._tolerance)


def described(sample: Sample, total: int) -> str:
    """Describe a sample."""
    settle = f", after {sample.first - sample.begin} to settle in" if sample.first > sample.begin else ""
    which = "other " if sample.number else ""
    how = f"{sample.patches} patches of neighbours" if sample.patches < sample.strands else "each on its own"
    return f"{sample.strands} of {total:,} {which}strands, {how}; frames {sample.first}-{sample.last}{settle}"


def look_at(request: Request) -> Scene:
    """Count the strands of a scene, measure the motion of its roots, and find whether hair may be chaotic.

    Raises BadInput where the node does not simulate hair, or what it needs cannot be computed.
    """
    shot = request.shot
    model_in(shot.graph, request.hair)
    tables = shot.tables
    edges = tables[request.hair]["in"]
    groom = shot.nodes[request.hair].edges["groom"].node
    drivers = {name: edges[name] for name in ("body", "ends") if name in edges}
    if drivers:
        tables = with_node(tables, ROOTS, {"type": "measure_roots", "in": {"groom": edges["groom"]} | drivers})
    wanted = shot.edited(tables)
    outcome = request.run("how the roots move", wanted, [ROOTS if drivers else groom], wanted.frames)
    if outcome.interrupted:
        raise Interrupted
    if outcome.failures:
        raise BadInput(str(outcome.failures[0]), where=shot.path)
    results = Results(wanted, wanted.frames)
    strands = results.value(groom)
    scene = Scene(len(strands.ids), None, tip_of(request, strands))
    if not drivers:
        return scene
    roots = results.value(ROOTS)
    speeds, accelerations = (np.array(roots[name]) for name in ("speed [m/s]", "acceleration [m/s^2]"))
    return scene._replace(motion=accelerations, hardest=hardest(speeds, accelerations, shot.fps))


def tip_of(request: Request, groom: Groom) -> float | None:
    """Return the imperceptible difference of members of an ensemble [m]; None as in `Scene`."""
    held = groom.tip_triangles is not None and (groom.tip_triangles >= 0).any()
    if held or not touches(request.shot.graph.node(request.hair)):
        return None
    value, unit = request.tolerance
    length = 0.01 * float(np.median(strand_lengths(groom.points, groom.offsets))) if unit == "%" else 1.0
    return max(float(f"{INDIFFERENT * value * length:.6g}"), LEAST)
