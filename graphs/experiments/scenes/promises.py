"""Whether promises are kept: what tuning chooses, on strands, at frames and in a motion that it has not seen."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

from hairpipe.app.api.formatting import plural
from hairpipe.app.api.shot import Shot
from hairpipe.app.tune.report import plain
from hairpipe.app.tune.sampling import STILL, RootMotion, other_sample
from hairpipe.app.tune.study import Request, RunNodes
from hairpipe.app.tune.tuning import Check, Checking, Tuned, Untunable, look_at, sample_of, tune
from hairpipe.graphs.experiments.scenes import cells
from hairpipe.graphs.experiments.scenes.drawing import HAIR, DrawnScene

Verdict = Literal["kept", "outside", "broken", "inconclusive", "refused", "fails"]
VERDICTS: dict[Verdict, str] = {
    "kept": "within the tolerance",
    "outside": "the motion is harder than those that the promise holds for",
    "inconclusive": "beyond it by what may be chance, or where the graph as it is does not keep it either",
    "broken": "beyond it, where the graph as it is keeps it",
    "refused": "nothing keeps the tolerance, on the sample or in a check, and nothing was promised",
    "fails": "the graph as it is does not get through",
}
"""What can become of a promise, the best first."""
HEADINGS = ("", "scene", "within", "left out, or coarser", "error", "elsewhere", "in another motion", "faster", "")
ALIGN = "><><>>>><"


@dataclass(frozen=True)
class Promise:
    """A scene, what was chosen for it, and what became of that.

    number     of the scene
    tuned      None where the graph as it is does not get through
    elsewhere  the choice on strands and frames that it was neither sampled nor checked on; None where nothing was
               promised
    other      the choice on the same strands in another motion; None where nothing was promised
    motion     hardest of the other motion
    """

    number: int
    scene: DrawnScene
    tuned: Tuned | None
    elsewhere: Check | None = None
    other: Check | None = None
    motion: RootMotion = STILL

    @property
    def verdicts(self) -> tuple[Verdict, Verdict]:
        """What became of the promise on other strands and frames, and in another motion."""
        if self.tuned is None:
            return "fails", "fails"
        if self.elsewhere is None or self.other is None:
            return "refused", "refused"
        tolerance = self.scene.tolerance.value
        within = self.tuned.motion.includes(self.motion)
        return verdict_of(self.elsewhere, tolerance), verdict_of(self.other, tolerance) if within else "outside"


def verdict_of(check: Check, tolerance: float) -> Verdict:
    """Judge a promise where it was checked."""
    if check.chosen.kept(tolerance):
        return "kept"
    return "broken" if check.chosen.broke(tolerance) and check.full.kept(tolerance) else "inconclusive"


def try_promise(shot: Shot, number: int, scene: DrawnScene, run: RunNodes, echo: Callable[[str], None]) -> Promise:
    """Tune a scene, and measure the choice where it was not chosen, and on the same strands in another motion.

    shot  of any graph in the folder that the scene's files are in, with the cache
    """
    request = Request(shot.edited(scene.tables), HAIR, scene.tolerance, run, check=True)
    try:
        tuned = tune(request, echo)
    except Untunable:
        return Promise(number, scene, None)
    parts = tuned.choice.parts
    if parts is None or not tuned.kept:
        return Promise(number, scene, tuned)
    known = [tuned.sample, *(check.sample for check in tuned.checks)]
    seen = look_at(request)
    third = other_sample(known, request.shot.frames, request.shot.fps, seen.motion, tuned.strands)
    elsewhere = Checking(request, third, seen, echo).check(parts)
    _, tables = scene.other
    moved = replace(request, shot=shot.edited(tables))
    seen = look_at(moved)
    sample = replace(sample_of(moved, seen), number=third.number)
    other = Checking(moved, sample, seen, echo).check(parts)
    return Promise(number, scene, tuned, elsewhere, other, seen.hardest)


def rows(promises: Sequence[Promise]) -> list[tuple[str, ...]]:
    """Lay out what was promised, and what became of it."""
    return [HEADINGS, *map(row, promises)]


def row(promise: Promise) -> tuple[str, ...]:
    """Write one promise: errors, with their bounds, in the unit of the tolerance."""
    scene = promise.scene
    tuned = promise.tuned
    other = promise.other
    tolerance = promise.scene.tolerance
    common = (str(promise.number), f"{scene.text}; then {scene.other[0]}", str(tolerance))
    if tuned is None:
        return (*common, "", "", "", "", "", worst(promise))
    checks = [check for check in (promise.elsewhere, other) if check]
    errors = [cells.error(found, tolerance) for found in (tuned.choice.measured, *(check.chosen for check in checks))]
    reasons = dict.fromkeys(check.chosen.refused for check in checks if check.chosen.refused)
    if promise.verdicts[1] == "outside":
        reasons[f"the other motion, up to {promise.motion}, is outside of {tuned.motion}"] = None
    verdict = ": ".join(filter(None, (worst(promise), "; ".join(reasons))))
    return (*common, cells.left_out(tuned), *(errors + 2 * [""])[:3], cells.faster(tuned), verdict)


def worst(promise: Promise) -> Verdict:
    """Return the worse of the two verdicts, of the first alone where the other motion is outside of the promise."""
    first, second = promise.verdicts
    return first if second == "outside" else max(first, second, key=[*VERDICTS].index)


def summary(promises: Sequence[Promise]) -> list[str]:
    """Count what became of promises: all of them, on other strands or frames, and in another motion."""
    made = [promise for promise in promises if promise.other is not None]
    counts = Counter(map(worst, promises))
    lines = [f"{counts['kept']} of {plural(len(made), 'promise')} kept, of {plural(len(promises), 'scene')}"]
    for place, name in enumerate(("on other strands or frames", "in another motion") if made else ()):
        kept = Counter(promise.verdicts[place] for promise in made)
        lines.append(f"{name}: {', '.join(f'{kept[verdict]} {verdict}' for verdict in VERDICTS if kept[verdict])}")
    return lines + [f"{verdict}: {counts[verdict]}, {VERDICTS[verdict]}" for verdict in VERDICTS if counts[verdict]]


def document(promises: Sequence[Promise]) -> list[dict[str, Any]]:
    """Describe promises for a JSON document."""
    return [
        {
            "number": promise.number,
            "scene": promise.scene.text,
            "other": promise.scene.other[0],
            "tolerance": promise.scene.tolerance._asdict(),
            "verdicts": promise.verdicts,
            "left_out": promise.tuned and cells.left_out(promise.tuned),
            "promised": promise.tuned and plain(promise.tuned.choice.measured),
            "checks": promise.tuned and [plain(check.chosen) for check in promise.tuned.checks],
            "elsewhere": promise.elsewhere and plain(promise.elsewhere.chosen),
            "other_motion": promise.other and plain(promise.other.chosen),
            "holds_for": promise.tuned and asdict(promise.tuned.motion),
            "moves_by": asdict(promise.motion),
        }
        for promise in promises
    ]
