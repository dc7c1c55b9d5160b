"""Results of tuning: rows of a table, sentences, a document, and settings to replace those of the graph file."""

from collections.abc import Mapping
from dataclasses import asdict
from types import MappingProxyType
from typing import Any

from hairpipe.app.api.formatting import duration, table
from hairpipe.app.tune.measured import MODEL, REFERENCE, Chaos, Measured, Tolerance, differences
from hairpipe.app.tune.sampling import RootMotion
from hairpipe.app.tune.study import AS_IT_IS
from hairpipe.app.tune.tuning import Check, Choice, Combination, Trial, Tuned, described, names, saves
from hairpipe.engine.file.overrides import Tables
from hairpipe.engine.node.messages import one_line
from hairpipe.measure.climate import TESTED
from hairpipe.measure.ensemble import CONFIDENCE

HEADINGS = ("model", "tips [mm]", "[% of L]", "bound", "whole [mm]", "s/frame", "saves", "")
ALIGN = "<>>>>>><"


def text_of(tuned: Tuned, motions: Mapping[str, RootMotion]) -> str:
    """Write the results for a terminal, with the motions of other graphs by their names."""
    faults, tried = ([*map(one_line, lines)] for lines in (fault_lines(tuned), trial_lines(tuned)))
    sentences = conclusion(tuned) + motion_lines(tuned, motions)
    parts = (header(tuned), [table(rows(tuned), ALIGN)], faults, tried, sentences)
    return "\n\n".join("\n".join(lines) for lines in parts if lines)


def header(tuned: Tuned) -> list[str]:
    """Describe the sample, and the convergence of the reference within the tolerance, or its chaos."""
    reference, tolerance = tuned.reference, tuned.tolerance
    lines = [f"sample: {described(tuned.sample, tuned.strands)}", reference_line(tuned.steps, reference, tolerance)]
    if not isinstance(reference, Chaos):
        beyond = f"the reference is not converged within {tolerance}: motion like this cannot be held to it"
        return lines + [beyond] * (reference.error > tolerance.value)
    floor = f"chaos floor {length(reference.floor, tolerance)} ({len(MODEL)} + {len(REFERENCE)} members)"
    until = f"up to frame {reference.frame} only" if reference.predicted else "at no frame"
    beyond = f"{floor}: a tolerance of {tolerance} can be promised {until}"
    return lines + [beyond] * (reference.floor > tolerance.value)


def reference_line(steps: str, found: Measured | Chaos, tolerance: Tolerance) -> str:
    if isinstance(found, Chaos):
        members = f"reference: {len(REFERENCE)} members, {steps}, tips aimed {millimetres(found.tip)} mm apart"
        apart = length(found.apart, tolerance)
        if not found.chaotic:
            return f"{members}; not chaotic: they are at most {apart} apart"
        return f"{members}; chaotic: {apart} apart after frame {found.frame}, floor {length(found.floor, tolerance)}"
    if steps == AS_IT_IS:
        return f"reference: {steps}, which takes no steps in time"
    if found.fault:
        return f"reference: {steps}; twice as long ones: {found.fault}"
    moved = f"{millimetres(found.tip)} mm ({found.percent:.2g} %)"
    return f"reference: {steps}; twice as long ones move its tips by {moved}"


def rows(tuned: Tuned) -> list[tuple[str, ...]]:
    """Lay out the measurements: the full model, then each simplification on its own, with the verdict."""
    full = tuned.full
    reason = "" if full.keeps(tuned.tolerance.value) else f"may be beyond {tuned.tolerance}"
    models = [(AS_IT_IS, full, reason)]
    models += [(part.text, found, why(tuned, Combination([part]), found)) for part, found in tuned.singles.items()]
    cells: list[tuple[str, ...]] = [HEADINGS]
    for text, found, verdict in models:
        numbers = [""] * (len(HEADINGS) - 2)
        if not found.fault:
            saved = "" if found is full else f"{100.0 * (1.0 - found.seconds / full.seconds):.0f} %"
            bound = length(found.bound, tuned.tolerance)
            whole = millimetres(found.whole)
            error = [millimetres(found.tip), f"{found.percent:.2g}", bound, whole]
            numbers = [*error, f"{found.seconds:.3g}", saved]
        cells.append((text, *numbers, verdict))
    return cells


def fault_lines(tuned: Tuned) -> list[str]:
    """List the simplifications that failed, with their faults."""
    return [f"{part.text}: {found.fault}" for part, found in tuned.singles.items() if found.fault]


def trials(tuned: Tuned) -> list[Trial]:
    return [*tuned.choice.trials, *(tuned.affordable.trials if tuned.affordable else ())]


def trial_lines(tuned: Tuned) -> list[str]:
    """List the combinations that were measured, with predicted and measured errors, cost and verdict."""
    lines = []
    for guess, found in trials(tuned):
        if guess.parts == tuned.choice.parts:
            verdict = "taken"
        elif tuned.affordable and guess.parts == tuned.affordable.parts:
            verdict = "what the budget buys"
        elif found.bound > tuned.tolerance.value:
            verdict = "not taken, may be beyond"
        elif guess.parts in tuned.choice.failed:
            verdict = "not taken, beyond it in a check"
        else:
            verdict = f"not taken, {found.refused or 'costs more'}"
        cost = "" if found.fault else f", {found.seconds:.3g} s/frame"
        expected = f"expected at most {length(guess.bound, tuned.tolerance)}"
        names = "; ".join(names_of(guess.parts))
        lines.append(f"together: {names}\n  {shown(found, tuned.tolerance)}, {expected}{cost}: {verdict}")
    return lines


def why(tuned: Tuned, parts: Combination, found: Measured) -> str:
    chosen = tuned.choice.parts
    if found.fault:
        return "kept: fails, see below"
    if parts == chosen:
        return "left out"
    if found.bound > tuned.tolerance.value:
        return f"kept: may be beyond {tuned.tolerance}"
    if found.refused:
        return f"kept: {found.refused}"
    if parts in tuned.choice.failed:
        return f"kept: beyond {tuned.tolerance} in a check"
    if chosen is None:
        return (
            "kept: keeps it only as far as hair can be predicted" if found.screened else "kept: smaller error by chance"
        )
    if chosen and parts <= chosen:
        return "left out"
    if not all(saves(part, found, tuned.full) for part in parts):
        return "kept: saves nothing"
    if chosen and any(part.axis == other.axis and part.level < other.level for part in parts for other in chosen):
        return "more than that is left out"
    return "kept: not with the others" if len(parts) == 1 else "costs more"


def conclusion(tuned: Tuned) -> list[str]:
    """Describe the choice, its saving, and the result on the second sample."""
    choice, full, tolerance = tuned.choice, tuned.full, tuned.tolerance
    error = shown(choice.measured, tolerance)
    if choice.parts is None:
        lines = [f"nothing keeps {tolerance}: not even the unchanged graph, with an error of {error}"]
        lines += [choice.measured.refused] * bool(choice.measured.refused)
        if isinstance(tuned.reference, Chaos) and tuned.reference.chaotic:
            lines.append(f"up to frame {tuned.reference.frame} its tips are {millimetres(full.tip)} mm off")
        else:
            lines.append("shorter steps may; a smaller error of a simpler model is chance")
    else:
        saved = f"{full.seconds / choice.measured.seconds:.1f} times as fast"
        nothing = "nothing, the scene needs the unchanged graph" if tuned.stopped is None else "nothing so far"
        reach = f"holds for motions whose roots reach no more than {tuned.motion} over half a second"
        lines = [
            f"left out: {'; '.join(names_of(choice.parts)) or nothing}",
            f"error {error}",
            f"{choice.measured.seconds:.3g} s a frame, not {full.seconds:.3g}: {saved}",
            *promise_lines(tuned),
            reach if tuned.motion.speed > 0.0 else "holds where roots are at rest",
        ]
    if tuned.stopped is not None:
        lines.append(f"stopped after {duration(tuned.stopped)} of processor time: the best so far; --time allows more")
    if tuned.affordable is not None:
        lines.append(affordable_line(f"{tuned.budget:g} s a frame", tolerance, tuned.affordable))
    return lines + [line for check in tuned.checks for line in check_lines(tuned, check)]


def promise_lines(tuned: Tuned) -> list[str]:
    """State the guarantee for chaotic hair: its duration, and its quantities afterwards."""
    chaos = tuned.reference
    climate = tuned.choice.measured.climate
    if not isinstance(chaos, Chaos) or climate is None:
        return []
    lines = [
        f"keeps {tuned.tolerance} with {100 * CONFIDENCE:.0f} % confidence up to frame {chaos.frame} "
        f"({chaos.seconds:.2f} s); chaos: from then on two references are {length(chaos.apart, tuned.tolerance)} apart",
        f"afterwards the error of its mean is at most {length(climate.bound, tuned.tolerance)}",
    ]
    if climate.score is None:
        lines.append("too few frames remain for statistics")
    apart = differences(climate)
    if apart:
        lines.append(f"differs significantly from the reference in {', '.join(apart)}; --looks refuses such models")
    elif climate.score is not None:
        lines.append(f"does not differ significantly from the reference in {', '.join(TESTED)}, or spread")
    return lines


def motion_lines(tuned: Tuned, motions: Mapping[str, RootMotion]) -> list[str]:
    """State for motions of other graphs, by their names, whether the promise holds there."""
    if tuned.choice.parts is None:
        return []
    return [
        f"{name}: roots reach {motion}: {'within' if tuned.motion.includes(motion) else 'outside of'} these motions"
        for name, motion in motions.items()
    ]


def affordable_line(budget: str, tolerance: Tolerance, found: Choice) -> str:
    if found.parts is None:
        return f"nothing that was measured costs {budget} or less: the cheapest costs {found.measured.seconds:.3g} s"
    error = shown(found.measured, tolerance)
    what = "; ".join(names_of(found.parts))
    line = f"{budget} buy an error of {error}, for {found.measured.seconds:.3g} s, with these left out: {what}"
    return f"{line}; {found.measured.refused}" if found.measured.refused else line


def check_lines(tuned: Tuned, check: Check) -> list[str]:
    tolerance = tuned.tolerance
    frames = len(set(tuned.sample.frames) & set(check.sample.frames))
    both = ["all strands"] * (tuned.sample.number == check.sample.number) + [f"{frames} of the frames"] * (frames > 0)
    shared = f"; as in the sample: {' and '.join(both)}" if both else ""
    failed = check.chosen.refused or f"beyond {tolerance}"
    held = "the tolerance holds" if check.chosen.kept(tolerance.value) else failed
    chosen, own = shown(check.chosen, tolerance), shown(check.full, tolerance)
    return [
        f"check: {described(check.sample, tuned.strands)}{shared}",
        f"check: {reference_line(tuned.steps, check.reference, tolerance)}",
        f"check: error {chosen}; the graph as it is, {own}: {held}",
    ]


def comment(tuned: Tuned, command: str) -> str:
    """Write a comment for the settings: the command, the measurements, how to use them."""
    return "\n".join(
        [command, *header(tuned), *conclusion(tuned), "", "These tables take the place of those in the graph."]
    )


def document(
    tuned: Tuned, fragment: str | None, motions: Mapping[str, RootMotion] = MappingProxyType({})
) -> dict[str, Any]:
    """Describe the results of tuning as a JSON document, with the motions of other graphs by their names."""
    return {
        "strands": tuned.strands,
        "sample": asdict(tuned.sample),
        "tolerance": tuned.tolerance._asdict(),
        "kept": tuned.kept,
        "reference": {"steps": tuned.steps} | plain(tuned.reference),
        "full": plain(tuned.full),
        "simplifications": [
            asdict(part) | plain(found) | {"verdict": why(tuned, Combination([part]), found)}
            for part, found in tuned.singles.items()
        ],
        "combinations": [
            {"left_out": names_of(guess.parts), "guess": {"bound": guess.bound, "seconds": guess.seconds}}
            | plain(found)
            for guess, found in trials(tuned)
        ],
        "chosen": choice_document(tuned.choice),
        "holds_for": asdict(tuned.motion),
        "also": {name: asdict(motion) | {"within": tuned.motion.includes(motion)} for name, motion in motions.items()},
        "stopped": tuned.stopped,
        "budget": tuned.budget,
        "affordable": tuned.affordable and choice_document(tuned.affordable),
        "checks": [
            {"sample": asdict(check.sample)}
            | {name: plain(getattr(check, name)) for name in ("reference", "full", "chosen")}
            for check in tuned.checks
        ],
        "fragment": fragment,
    }


def choice_document(choice: Choice) -> dict[str, Any] | None:
    return None if choice.parts is None else {"left_out": names_of(choice.parts)} | plain(choice.measured)


def plain(found: Measured | Chaos) -> dict[str, Any]:
    """Describe a measurement; an infinite value is null."""
    return {name: None if value == float("inf") else value for name, value in asdict(found).items()}


def names_of(parts: Combination) -> list[str]:
    """List the omitted parts in words."""
    return [part.text for part in sorted(parts, key=lambda part: names([part]))]


def shown(found: Measured, tolerance: Tolerance) -> str:
    if found.fault:
        return found.fault
    bound = f"{found.bound:.2g}" if tolerance.unit == "%" else millimetres(found.bound)
    return f"{length(found.error, tolerance)} (at most {bound})"


def length(value: float, tolerance: Tolerance) -> str:
    """Write a length in the tolerance's unit."""
    return f"{value:.2g} %" if tolerance.unit == "%" else f"{millimetres(value)} mm"


def millimetres(metres: float) -> str:
    """Write a length in mm to two figures."""
    value = 1e3 * metres
    return f"{value:.0f}" if value >= 99.5 else f"{value:.2g}"


def changed_tables(before: Tables, after: Tables) -> Tables:
    """Return the tables of nodes that have changed."""
    return {name: table for name, table in after.items() if isinstance(table, dict) and table != before.get(name)}


def write_toml(tables: Tables, comment: str) -> str:
    """Write tables of nodes as TOML, below a comment; edges stay on one line."""
    import tomlkit

    written = tomlkit.document()
    for name, settings in tables.items():
        table = tomlkit.item(settings)
        if "in" in settings:
            table["in"] = tomlkit.inline_table()
            table["in"].update(settings["in"])
        written.add(name, table)
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    return "\n".join([*lines, "", tomlkit.dumps(written)])
