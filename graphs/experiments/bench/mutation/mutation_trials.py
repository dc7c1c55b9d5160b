"""Mutations of the engine and of the laws, tried with the tests of each file in a copy of the checkout."""

import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from difflib import unified_diff
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.mutation import tester
from hairpipe.graphs.experiments.bench.mutation.suites import PACKAGE, SUITES, TESTS, room_of
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

if TYPE_CHECKING:
    from hairpipe.graphs.experiments.bench.mutation.places import Mutant

HOME = Path(__file__).parents[4]
COPIED = ("hairpipe", "tests/engine", "tests/laws", "tests/contact", "tests/app/cli", "tests/*.py", "pyproject.toml")
PYTEST = ("-x", "-q", "-p", "no:cacheprovider", "-p", "no:randomly")
QUICK = ("-m", "not kernels and not slow")
"""Tests of the engine: those of the laws compile kernels."""
LEAST, FACTOR = 30.0, 4.0
"""A mutation is stopped after this time [s], or after this multiple of the time of the tests of unchanged code."""
Z = 1.96
"""Quantile of the normal distribution for an interval of 95 %."""


class Trial(NamedTuple):
    """A mutation and what the tests made of it.

    file     in `hairpipe`
    line     first one that is changed
    change   of the source, as two lines
    outcome  killed, stopped (after too long a time) or survived
    """

    file: str
    line: int
    change: str
    outcome: str


class Tester:
    """A copy of the checkout, and a process that runs tests in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._stamp = int(time.time()) - 10_000_000
        for pattern in COPIED:
            for path in HOME.glob(pattern):
                target = folder / path.relative_to(HOME)
                target.parent.mkdir(parents=True, exist_ok=True)
                omitted = shutil.ignore_patterns("__pycache__")
                shutil.copytree(path, target, ignore=omitted) if path.is_dir() else shutil.copy(path, target)
        variables = os.environ | {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "kernels")}
        command = [sys.executable, "-P", str(Path(tester.__file__).resolve())]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=folder, env=variables, stdin=pipe, stdout=pipe, text=True)

    def run(self, file: str, limit: float) -> int | None:
        """Run the tests of a file; returns the exit code of pytest, None where the limit [s] was reached."""
        assert self.process.stdin and self.process.stdout
        selection = () if room_of(file) == "laws" else QUICK
        words = [*PYTEST, *selection, *(os.path.normpath(f"{TESTS}/{name}") for name in SUITES[file])]
        self.process.stdin.write(json.dumps([words, limit]) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def write(self, file: str, source: str) -> None:
        """Write a file of the copy, with a time of its own: Python compares times in seconds with compiled code."""
        path = self.folder / PACKAGE / file
        path.write_text(source, encoding="utf-8")
        self._stamp += 2
        os.utime(path, (self._stamp, self._stamp))


@contextmanager
def testing() -> Iterator[Tester]:
    """Make a tester in a temporary folder."""
    with tempfile.TemporaryDirectory(prefix="hairpipe-mutation-") as folder:
        tester = Tester(Path(folder))
        try:
            yield tester
        finally:
            tester.process.communicate()  # closes its input, at whose end it ends


def mutated_files(rooms: Sequence[str]) -> list[Path]:
    """List the files of rooms that are mutated."""
    return [HOME / PACKAGE / file for file in SUITES if room_of(file) in rooms]


def source_of(file: str) -> str:
    """Read a file of the package."""
    return (HOME / PACKAGE / file).read_text(encoding="utf-8")


def drawn(room: str, most: int, seed: int) -> tuple[list[tuple[str, list["Mutant"]]], int]:
    """Draw places in the files of a room; returns file and mutations of each, and the number of all places."""
    from hairpipe.graphs.experiments.bench.mutation.places import draw_places

    places = []
    for file in (name for name in SUITES if room_of(name) == room):
        draw = random.Random(f"{seed} {file}")
        places += [(file, mutants) for mutants in draw_places(source_of(file), draw)]
    order = list(range(len(places)))  # of which a larger sample contains a smaller one
    random.Random(f"{seed} {room}").shuffle(order)
    return [places[number] for number in sorted(order[:most])], len(places)


def change_of(source: str, changed: str) -> tuple[int, str]:
    """Describe a change: the line, and its text before and after."""
    lines = list(unified_diff(source.splitlines(), changed.splitlines(), n=0, lineterm=""))[2:]
    line = int(lines[0].split()[1].lstrip("-").partition(",")[0])
    return line, " | ".join(text[0] + " " + text[1:].strip() for text in lines if text[0] in "+-")


def try_mutations(say: Echo, rooms: Sequence[str], most: int, seed: int, known: Path | None) -> Report:
    """Try mutations of each room; BadInput where Cosmic Ray is absent or a test fails on unchanged code.

    most   number of mutations of a room
    known  file of earlier outcomes, a line of JSON each, to which this run adds; killed mutations are not tried again
    """
    if find_spec("cosmic_ray") is None:
        raise BadInput("Cosmic Ray is not installed", where="mutate", right='pip install "hairpipe[mutation]"')
    from hairpipe.graphs.experiments.bench.mutation.places import changed_source

    earlier = read_outcomes(known)
    scores: list[Case] = []
    survivors: list[Case] = []
    with testing() as tester:
        for room in rooms:
            chosen, places = drawn(room, most, seed)
            limits: dict[str, float] = {}
            trials = []
            for number, (file, mutants) in enumerate(chosen):
                source = source_of(file)
                changed = changed_source(source, mutants)
                if changed is None:
                    continue
                line, change = change_of(source, changed)
                outcome = earlier.get((file, line, change), ["survived"])[-1]
                if outcome == "survived":
                    if file not in limits:
                        limits[file] = limit_of(tester, file)
                    outcome = outcome_of(tester, file, source, changed, limits[file])
                    if known is not None:
                        with known.open("a", encoding="utf-8") as lines:
                            lines.write(json.dumps(Trial(file, line, change, outcome)) + "\n")
                trials.append(Trial(file, line, change, outcome))
                say(f"{number + 1} of {len(chosen)} {outcome} {file}:{line} {change if outcome == 'survived' else ''}")
            first = [trial._replace(outcome=(earlier.get(trial[:3]) or [trial.outcome])[0]) for trial in trials]
            if trials:
                scores.append({"room": room, "places": places, "first [%]": share_of(first), **score_of(trials)})
            survivors += [trial._asdict() for trial in trials if trial.outcome == "survived"]
    return make_report(__name__, {"scores": scores, "survivors": survivors})


def limit_of(tester: Tester, file: str) -> float:
    """Run the tests of a file unchanged; returns the time after which a mutation of it is stopped [s]."""
    begin = time.monotonic()
    tester.write(file, source_of(file))
    if tester.run(file, 3600.0) != 0:
        raise BadInput("a test fails on unchanged code", where=" ".join(SUITES[file]), right="all must pass")
    return max(LEAST, FACTOR * (time.monotonic() - begin))


def outcome_of(tester: Tester, file: str, source: str, changed: str, limit: float) -> str:
    """Try a mutation, and put the source back."""
    tester.write(file, changed)
    try:
        code = tester.run(file, limit)
    finally:
        tester.write(file, source)
    return "stopped" if code is None else "survived" if code == 0 else "killed"


def read_outcomes(known: Path | None) -> dict[tuple[str, int, str], list[str]]:
    """Read the outcomes of mutations in earlier runs, by file, line and change, the first of them first."""
    outcomes: dict[tuple[str, int, str], list[str]] = {}
    for line in known.read_text(encoding="utf-8").splitlines() if known and known.exists() else ():
        trial = Trial(*json.loads(line))
        outcomes.setdefault(trial[:3], []).append(trial.outcome)
    return outcomes


def share_of(trials: Sequence[Trial]) -> float:
    """Return the share of mutations that did not survive [%]."""
    return 100.0 * sum(trial.outcome != "survived" for trial in trials) / len(trials)


def score_of(trials: Sequence[Trial]) -> Case:
    """Count outcomes; the score is the share of killed and stopped ones, with Wilson's interval of 95 %."""
    count = len(trials)
    counts = {name: sum(trial.outcome == name for trial in trials) for name in ("killed", "stopped", "survived")}
    share = share_of(trials) / 100.0
    middle = share + Z * Z / (2 * count)
    weight = 1.0 + Z * Z / count
    half = Z * math.sqrt(share * (1.0 - share) / count + (Z / (2 * count)) ** 2)
    bounds = {"from [%]": 100.0 * (middle - half) / weight, "to [%]": 100.0 * (middle + half) / weight}
    return {"tried": count, **counts, "score [%]": 100.0 * share, **bounds}
