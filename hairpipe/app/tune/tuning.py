"""Tune a scene: choose a sample, measure error and time of each simplification, and choose a combination."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hairpipe.app.tune.chaos import INDIFFERENT, LEAST, Chaos
from hairpipe.app.tune.choosing import Choice, Combination, choose, choose_within, saves
from hairpipe.app.tune.measured import Measured, Results
from hairpipe.app.tune.quantity import Tolerance
from hairpipe.app.tune.sampling import PATCHES, STILL, RootMotion, Sample, choose_sample, hardest, other_sample
from hairpipe.app.tune.simplifications import model_in, simplifications, touches
from hairpipe.app.tune.study import Interrupted, Request, Study, simplified, with_node
from hairpipe.engine.file.overrides import Tables
from hairpipe.errors import BadInput
from hairpipe.values import Groom
from hairpipe.values.groom import strand_lengths
from hairpipe.values.simplification import Simplification

ROOTS = "tune-roots"
SHARE, LEAST_TIME = 0.1, 600.0
"""Time after which no other model is measured: a share of that of the shot's own simulation, and a minimum [s]."""
AT_ONCE = 4
"""Number of models whose members are simulated between two looks at the time."""


class Untunable(BadInput):
    """The unchanged graph, or its reference, fails on the sample."""


@dataclass(frozen=True)
class Check:
    """The choice, measured on strands and frames outside the sample, if the scene has any.

    reference  as in `Tuned`
    """

    sample: Sample
    reference: Measured | Chaos
    full: Measured
    chosen: Measured


@dataclass(frozen=True)
class Tuned:
    """The results of tuning.

    strands     number of strands of the scene
    reference   change of its tips when its steps were halved, or where hair acts on hair, its chaos
    steps       steps of the reference, in words
    full        measurement of the unchanged graph
    singles     each simplification on its own
    motion      hardest motion of the shot: the promise holds for motions that are no harder
    stopped     processor time after which nothing else was measured [s]; None: it was enough
    budget      requested processor time of a frame [s]
    affordable  choice within the budget, where the choice for the tolerance costs more
    """

    strands: int
    sample: Sample
    tolerance: Tolerance
    reference: Measured | Chaos
    steps: str
    full: Measured
    singles: dict[Simplification, Measured]
    choice: Choice
    budget: float | None = None
    affordable: Choice | None = None
    check: Check | None = None
    stopped: float | None = None
    motion: RootMotion = STILL

    @property
    def kept(self) -> bool:
        """Whether the error is within the tolerance, on the second sample too, if there was one."""
        if self.choice.parts is None or self.check is None:
            return self.choice.parts is not None
        return self.check.chosen.kept(self.tolerance.value)


class Scene(NamedTuple):
    """Properties of a scene before the simulation.

    strands  number of its strands
    motion   acceleration of its roots [m/s^2], (frames,); None if no root moves
    tip      initial difference of members of an ensemble [m]; None where hair does not act on hair and is not
             chaotic, or where tips are held, so that members cannot be made
    hardest  motion of its roots
    """

    strands: int
    motion: np.ndarray | None
    tip: float | None
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
    parts = simplifications(shot.graph, request.hair)
    scene = look_at(request)
    parts = [part for part in parts if part.count <= scene.strands]
    sample = sample_of(request, scene)
    study = Study(request, sample, scene.strands, scene.tip)
    echo(described(sample, scene.strands))
    reference = study.converged()
    full = study.measure([])
    fault = full.fault or (reference.fault if isinstance(reference, Measured) else "")
    if fault:
        raise Untunable(f"the unchanged graph fails on the sample: {fault}", where=request.shot.path)
    study.limit = request.time or max(SHARE * full.seconds * len(shot.frames), LEAST_TIME)
    singles = measured_singles(study, parts)
    if full.screened:
        full, screened = study.confirm([]), full
        if full.keeps(request.tolerance.value):
            worthy = [part for part, found in singles.items() if is_worthy(request.tolerance, part, found, screened)]
            worthy.sort(key=lambda part: singles[part].seconds)
            for some in (worthy[at : at + AT_ONCE] for at in range(0, len(worthy), AT_ONCE)):
                if study.has_time():
                    singles |= zip(some, study.confirm_all([part] for part in some), strict=True)
    second = Checking(request, other_sample([sample], shot.frames, shot.fps, scene.motion, scene.strands), scene, echo)
    passes = second.passes if request.check else lambda parts: True
    choice = choose(full, singles, request.tolerance.value, study.confirm, study.has_time, passes)
    stopped = study.limit if study.stopped else None
    affordable, check = None, None
    if request.budget is not None and (choice.parts is None or choice.measured.seconds > request.budget):
        affordable = choose_within(full, singles, request.budget, study.confirm, choice.trials)
    if request.check and choice.parts is not None:
        check = second.check(choice.parts)
    found = (study.steps, full, singles, choice, request.budget, affordable, check, stopped, scene.hardest)
    return Tuned(scene.strands, sample, request.tolerance, reference, *found)


def measured_singles(study: Study, parts: Sequence[Simplification]) -> dict[Simplification, Measured]:
    """Measure simplifications on their own while there is time: the first of every axis side by side, then the next."""
    found: dict[Simplification, Measured] = {}
    for level in sorted({part.level for part in parts}):
        some = [part for part in parts if part.level == level]
        if study.has_time():
            found |= zip(some, study.measure_all([part] for part in some), strict=True)
    return {part: found[part] for part in parts if part in found}


def is_worthy(tolerance: Tolerance, part: Simplification, found: Measured, full: Measured) -> bool:
    """Whether a model saves time and is within the tolerance in predictable frames, so that its climate is measured."""
    return found.keeps(tolerance.value) and saves(part, found, full)


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
        """Measure the unchanged graph and a choice."""
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
    tables = request.shot.tables
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
        raise BadInput(str(outcome.failures[0]), where=request.shot.path)
    results = Results(wanted, wanted.frames)
    strands = results.value(groom)
    total = len(strands.ids)
    tip = tip_of(request, strands)
    if not drivers:
        return Scene(total, None, tip)
    found = results.value(ROOTS)
    speeds, accelerations = (np.array(found[name]) for name in ("speed [m/s]", "acceleration [m/s^2]"))
    return Scene(total, accelerations, tip, hardest(speeds, accelerations, shot.fps))


def tip_of(request: Request, groom: Groom) -> float | None:
    """Return the imperceptible difference of members of an ensemble [m]; None as in `Scene`."""
    held = groom.tip_triangles is not None and (groom.tip_triangles >= 0).any()
    if held or not touches(request.shot.graph.node(request.hair)):
        return None
    value, unit = request.tolerance
    length = 0.01 * float(np.median(strand_lengths(groom.points, groom.offsets))) if unit == "%" else 1.0
    return max(float(f"{INDIFFERENT * value * length:.6g}"), LEAST)


def chosen_tables(request: Request, parts: Combination) -> Tables:
    """Return the tables of the graph with the choice applied."""
    return simplified(request.shot.tables, request.hair, parts)
