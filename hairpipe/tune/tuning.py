"""Tunes a scene: chooses a sample, measures error and time of each simplification, and chooses a combination."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hairpipe.api.shot import Shot
from hairpipe.errors import BadInput
from hairpipe.graph.file.overrides import Tables
from hairpipe.tune.choosing import Choice, Combination, choose, choose_within
from hairpipe.tune.measured import Measured
from hairpipe.tune.quantity import Tolerance
from hairpipe.tune.results import Results
from hairpipe.tune.sampling import PATCHES, STRANDS, Sample, choose_sample, other_sample
from hairpipe.tune.simplifications import Simplification, simplifications, touches
from hairpipe.tune.study import FINE, FINEST, CarryOut, Interrupted, Study
from hairpipe.tune.variants import simplified, with_node

ROOTS = "tune-roots"


@dataclass(frozen=True)
class Check:
    """The choice, measured on strands and frames that were not sampled, as far as the scene has others.

    reference  how far its tips moved when its steps were halved
    """

    sample: Sample
    reference: Measured
    full: Measured
    chosen: Measured


@dataclass(frozen=True)
class Tuned:
    """The results of tuning.

    strands     of the scene
    reference   how far its tips moved when its steps were halved, and
    steps       in words, which they are
    full        the graph as it is
    singles     each simplification on its own
    budget      processor time for a frame that was asked for [s]
    affordable  the choice within the budget, where the choice for the tolerance costs more
    """

    strands: int
    sample: Sample
    tolerance: Tolerance
    reference: Measured
    steps: str
    full: Measured
    singles: dict[Simplification, Measured]
    choice: Choice
    budget: float | None = None
    affordable: Choice | None = None
    check: Check | None = None

    @property
    def kept(self) -> bool:
        """Whether the tolerance is kept, and was on the second sample, if there was one."""
        return self.choice.parts is not None and (self.check is None or self.check.chosen.error <= self.tolerance.value)


@dataclass(frozen=True)
class Request:
    """What is to be tuned, and how.

    hair     node that simulates
    run      carries out a run
    budget   processor time for a frame, to report what error it buys [s]; None where that is not asked for
    check    whether the choice is measured on other strands and frames, too
    strands  of the sample
    """

    shot: Shot
    hair: str
    tolerance: Tolerance
    run: CarryOut
    budget: float | None = None
    check: bool = False
    strands: int = STRANDS


def tune(request: Request, say: Callable[[str], None] = lambda line: None) -> Tuned:
    """Measure a scene's own strands and frames, and choose; BadInput where the graph is none that can be tuned.

    say  receives a line about each measurement
    """
    if len(request.shot.frames) < 2:
        raise BadInput("one frame is no motion", where=request.shot.path, right="frames = [first, last] farther apart")
    with request.shot.keeping_workers() as shot:
        return measured_and_chosen(replace(request, shot=shot), say)


def measured_and_chosen(request: Request, say: Callable[[str], None]) -> Tuned:
    """Measure the graph as it is and each simplification, and choose; as `tune`, with workers that stay."""
    shot = request.shot
    parts = simplifications(shot.graph, request.hair)
    total, motion = look_at(request)
    parts = [part for part in parts if part.particles <= total]
    sample = sample_of(request, total, motion)
    study = study_of(request, sample, total)
    say(described(sample, total))
    reference = study.converged()
    full = study.measure([])
    if full.fault:
        raise BadInput(f"the graph itself does not get through the sample: {full.fault}", where=request.shot.path)
    singles = {part: study.measure([part]) for part in parts}
    choice = choose(full, singles, request.tolerance.value, study.measure)
    affordable, check = None, None
    if request.budget is not None and (choice.parts is None or choice.measured.seconds > request.budget):
        affordable = choose_within(full, singles, request.budget, study.measure, choice.trials)
    if request.check and choice.parts is not None:
        other = other_sample(sample, shot.frames, shot.fps, motion, total)
        check = checked(request, other, total, choice.parts, say)
    steps = study.refined(FINEST).text
    return Tuned(
        total, sample, request.tolerance, reference, steps, full, singles, choice, request.budget, affordable, check
    )


def sample_of(request: Request, total: int, motion: np.ndarray | None) -> Sample:
    """Choose what is measured; strands come with their neighbours where hair acts on hair."""
    patches = PATCHES if touches(request.shot.graph.node(request.hair)) else request.strands
    return choose_sample(request.shot.frames, request.shot.fps, motion, total, request.strands, patches)


def checked(request: Request, sample: Sample, total: int, parts: Combination, say: Callable[[str], None]) -> Check:
    """Measure the graph as it is and the choice on another sample."""
    study = study_of(request, sample, total)
    say(f"check: {described(sample, total)}")
    return Check(sample, study.measure([study.refined(FINE)]), study.measure([]), study.measure(parts))


def study_of(request: Request, sample: Sample, total: int) -> Study:
    """Begin to measure a sample."""
    return Study(request.shot, request.hair, sample, total, request.tolerance, request.run)


def described(sample: Sample, total: int) -> str:
    """Say what a sample consists of."""
    settle = f", after {sample.first - sample.begin} to settle in" if sample.first > sample.begin else ""
    which = "other " if sample.number else ""
    how = f"{sample.patches} patches of neighbours" if sample.patches < sample.strands else "each on its own"
    return f"{sample.strands} of {total:,} {which}strands, {how}; frames {sample.first}-{sample.last}{settle}"


def look_at(request: Request) -> tuple[int, np.ndarray | None]:
    """Count the strands of a scene, and measure how its roots accelerate [m/s^2], (frames,); None where none is led."""
    shot, tables = request.shot, request.shot.tables
    edges = tables[request.hair]["in"]
    groom = shot.nodes[request.hair].edges["groom"].node
    leads = {name: edges[name] for name in ("body", "ends") if name in edges}
    if leads:
        tables = with_node(tables, ROOTS, {"type": "measure_roots", "in": {"groom": edges["groom"]} | leads})
    wanted = shot.edited(tables)
    outcome = request.run("how the roots move", wanted, [ROOTS if leads else groom], wanted.frames)
    if outcome.interrupted:
        raise Interrupted
    if outcome.failures:
        raise BadInput(str(outcome.failures[0]), where=request.shot.path)
    results = Results(wanted, wanted.frames)
    total = len(results.value(groom).ids)
    if not leads:
        return total, None
    motion = np.array(results.value(ROOTS)["acceleration [m/s^2]"])
    for cut in shot.nodes[request.hair].settings["cuts"]:  # nothing moves there: hair is carried over
        motion[[place for place, frame in enumerate(shot.frames) if cut - 1 <= frame <= cut]] = 0.0
    return total, motion


def chosen_tables(request: Request, parts: Combination) -> Tables:
    """Return the tables of the graph with the choice left out."""
    return simplified(request.shot.tables, request.hair, parts)
