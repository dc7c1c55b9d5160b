"""What scenes need: for each, and for several tolerances, the cheapest model that keeps it, and what it leaves out."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from hairpipe.app.api.shot import Shot
from hairpipe.app.tune.measured import Tolerance
from hairpipe.app.tune.report import document as tuned_document
from hairpipe.app.tune.study import Request
from hairpipe.app.tune.tuning import Tuned, Untunable, tune
from hairpipe.graphs.experiments.scenes import cells
from hairpipe.graphs.experiments.scenes.pace import Pace

HEADINGS = ("scene", "within", "left out, or coarser", "error", "as it is", "faster")
ALIGN = "<><>>>"


class Need(NamedTuple):
    """What was found for a scene and a tolerance; None where the graph as it is does not get through."""

    scene: str
    tolerance: Tolerance
    tuned: Tuned | None


def needs_of(
    shots: Mapping[str, Shot], hair: str, tolerances: Sequence[Tolerance], pace: Pace, echo: Callable[[str], None]
) -> Iterator[Need]:
    """Tune scenes for several tolerances; runs that several of them need are carried out once.

    shots  by the names of scenes; hair  node of each that simulates
    """
    for name, shot in shots.items():
        with shot.keeping_workers() as kept:
            for tolerance in tolerances:
                with pace.scene(f"{name} within {tolerance}"):
                    yield Need(name, tolerance, found(Request(kept, hair, tolerance, pace.run), echo))


def found(request: Request, echo: Callable[[str], None]) -> Tuned | None:
    """Tune a scene; None where the graph as it is does not get through."""
    try:
        return tune(request, echo)
    except Untunable:
        return None


def rows(needs: Sequence[Need]) -> list[tuple[str, ...]]:
    """Lay out what scenes need; a scene is named once."""
    lines: list[tuple[str, ...]] = [HEADINGS]
    named = ""
    for scene, tolerance, tuned in needs:
        name = "the same" if scene == named else scene
        named = scene
        if tuned is None:
            lines.append((name, str(tolerance), "fails: the graph as it is does not get through", "", "", ""))
            continue
        chosen, full = (cells.error(measured, tolerance) for measured in (tuned.choice.measured, tuned.full))
        lines.append((name, str(tolerance), cells.left_out(tuned), chosen, full, cells.faster(tuned)))
    return lines


def document(needs: Sequence[Need]) -> list[dict[str, Any]]:
    """Describe what scenes need for a JSON document, each as `tune` does."""
    return [
        {
            "scene": need.scene,
            "within": need.tolerance._asdict(),
            "found": need.tuned and tuned_document(need.tuned, None),
        }
        for need in needs
    ]
