"""Trials of faults: whether a disturbed run ends with the bytes of an undisturbed one, and what that cost."""

import re
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.machines.end_state import CheckValue, differences, state_of
from hairpipe.graphs.experiments.bench.machines.fault_list import FAULTS, MOMENTS, Fault
from hairpipe.graphs.experiments.bench.machines.processes import PATIENCE
from hairpipe.graphs.experiments.bench.machines.scene import Scene
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

AT_ONCE = 3
"""Number of trials that run at the same time: most of them wait."""
PORT = re.compile(r"(?<=tcp://127\.0\.0\.1):\d+")
FOLDER = re.compile(r"/[^\s':]*hairpipe-machines-[^\s':]*")
"""What differs from trial to trial, and from machine to machine, in a message."""


@dataclass(frozen=True)
class Truth:
    """An undisturbed run.

    state        digests of results, objects and published files, by name
    evaluations  number of those that were made
    """

    state: dict[str, str]
    evaluations: int


def try_machines(echo: Echo, check_value: CheckValue, faults: Sequence[Fault] = FAULTS) -> Report:
    """Try every fault, in a folder that is removed afterwards."""
    with tempfile.TemporaryDirectory(prefix="hairpipe-machines-") as name, ThreadPoolExecutor(AT_ONCE) as pool:
        folder = Path(name).resolve()
        echo("an undisturbed run")
        truth = undisturbed(folder / "undisturbed", check_value)

        def try_next(numbered: tuple[int, Fault]) -> Case | None:
            number, fault = numbered
            case = try_fault(fault, folder / f"fault-{number}", truth, check_value)
            echo(f"{fault.title}: {verdict_of(case)}")
            return case

        cases = [case for case in pool.map(try_next, enumerate(faults)) if case is not None]
    return make_report(__name__, {"faults": cases})


def held(report: Report) -> bool:
    """Whether every fault ended as it has to."""
    return not any(case["violation"] for case in report.tables["faults"])


def verdict_of(case: Case | None) -> str:
    """Describe the end of a trial in a few words; pure."""
    return "not tried" if case is None else str(case["violation"] or "as required")


def undisturbed(folder: Path, check_value: CheckValue) -> Truth:
    """Run the shot; BadInput where that fails."""
    with Scene(folder, "local", ()) as scene:
        run = scene.start()
        if run.wait() != 0:
            raise BadInput(f"the shot itself fails: {run.text[-300:]}", where=scene.shot.graph)
        return Truth(state_of(scene.store, scene.shot.out, check_value), scene.shot.count())


def try_fault(fault: Fault, folder: Path, truth: Truth, check_value: CheckValue) -> Case | None:
    """Try a fault; None where this machine does not allow it."""
    try:
        scene = fault.scene(folder)
    except OSError:
        return None
    with scene:
        if fault.during:
            scene.shot.close_gate(fault.during)
        begun = time.monotonic()
        scene.start()
        if fault.during:
            scene.wait_for_gate()
        fault.act(scene)
        codes = [each.wait() for each in scene.runs]
        if codes[0] != 0:
            again = scene.start(fault.again)
            codes.append(again.wait())
        seconds = time.monotonic() - begun
        extra = scene.shot.count() - truth.evaluations
        lines = [line for each in scene.runs for line in each.text.splitlines()]
        violations = list(violations_of(fault, codes, lines, extra))
        if None not in codes:
            violations += differences(state_of(scene.store, scene.shot.out, check_value), truth.state)
        violations += [f"the lease {path.name} is left" for path in (scene.store / "lease").glob("*")]
    return {
        "fault": fault.what,
        "engine": fault.engine,
        "during": MOMENTS[fault.during],
        "exit code": codes[0],
        "next exit codes": " ".join(map(str, codes[1:])),
        "evaluated again": extra,
        "lost at most": fault.lost,
        "lines": len(lines),
        "message": without_places(lines[0]) if lines else "",
        "seconds [s]": round(seconds, 1),
        "violation": "; ".join(violations),
    }


def without_places(message: str) -> str:
    """Leave the port and the folder of a trial out of a message; pure."""
    return FOLDER.sub("...", PORT.sub("", message))


def violations_of(fault: Fault, codes: list[int | None], lines: list[str], extra: int) -> list[str]:
    """List what may not be: exit codes, evaluations, lines."""
    found = []
    if None in codes:
        found.append(f"a run does not end within {PATIENCE:g} s")
    if codes[0] not in (None, fault.code):
        found.append(f"exit code {codes[0]} in place of {fault.code}")
    if any(codes[1:]):
        found.append("a later run fails")
    if not 0 <= extra <= fault.lost:
        found.append(f"{extra} evaluations more than undisturbed, {fault.lost} lost")
    if len(lines) > fault.lines:
        found.append(f"{len(lines)} lines in place of {fault.lines}")
    return found
