"""Fault injection: poisoned folders, kills, damaged stores, runs concurrent with cleanings.

Each trial ends in the bytes of an undisturbed run, or in a refusal of one line; anything else is a fault. What
is done is chosen by a seed; when a kill strikes depends on the machine, too.
"""

import os
import random
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from hairpipe.engine.file.load import load_graph
from hairpipe.engine.plan.maintenance import Found, clean, verify
from hairpipe.engine.run.events import Options
from hairpipe.engine.run.scheduler import run
from hairpipe.engine.store.store import Store
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report
from hairpipe.graphs.experiments.bench.toy_shot import CHECKPOINT, Results, ToyShot, fault_of, results

CheckValue = Callable[[Path], str]
"""Gives the digest of the value in a file, as for `verify`."""


class Trials(NamedTuple):
    """How often each is tried: poisoned folders by module, kills, damages, shots of runs during cleanings."""

    kills: int = 60
    damages: int = 400
    cleanings: int = 30
    modules: tuple[str, ...] = ("json", "socket", "numpy", "h5py", "hairpipe", "numba", "typing", "toy_value")


class Truth(NamedTuple):
    """Results of an undisturbed run, its store, and its time [s]."""

    store: Path
    results: Results
    published: dict[str, bytes]
    seconds: float


class Count:
    """Trials of one kind, as they go."""

    def __init__(self, campaign: str, kind: str) -> None:
        self.name = (campaign, kind)
        self.tries = 0
        self.same = 0
        self.refused = 0
        self.twice = 0
        self.faults: list[str] = []

    def add(self, fault: str, *, refused: bool = False, twice: int = 0) -> None:
        """Count a trial."""
        self.tries += 1
        self.same += not fault and not refused
        self.refused += refused
        self.twice += twice
        if fault:
            self.faults.append(fault)

    @property
    def case(self) -> Case:
        """The trials so far; done twice are evaluations that were made though their result was there, and its state."""
        campaign, kind = self.name
        trials = {"trials": self.tries, "same bytes": self.same, "refused": self.refused}
        return {"campaign": campaign, "kind": kind, **trials, "faults": len(self.faults), "done twice": self.twice}


def held(report: Report) -> bool:
    """Whether all trials passed."""
    return not any(case["faults"] or case["done twice"] for case in report.tables["trials"])


def try_faults(echo: Echo, check_value: CheckValue, seed: int, trials: Trials | None = None) -> Report:
    """Run every campaign, in a folder that is removed afterwards."""
    trials = trials or Trials()
    counts: list[Count] = []
    with tempfile.TemporaryDirectory(prefix="hairpipe-faults-") as name, toy_shot(Path(name)) as shot:
        echo("an undisturbed run")
        truth = undisturbed(shot)
        campaigns = {
            "poisoned folders": lambda: try_poison(shot, truth, trials.modules),
            "kills": lambda: try_kills(shot, truth, random.Random(f"{seed} kills"), trials.kills),
            "damages": lambda: try_damages(shot, truth, random.Random(f"{seed} damages"), trials.damages, check_value),
            "cleanings during runs": lambda: try_cleanings(
                shot, truth, random.Random(f"{seed} cleanings"), trials.cleanings
            ),
        }
        for title, campaign in campaigns.items():
            echo(title)
            counts += [count for count in campaign() if count.tries]
    faults: list[Case] = [{"fault": fault} for count in counts for fault in count.faults]
    return make_report(__name__, {"trials": [count.case for count in counts], "faults": faults})


@contextmanager
def toy_shot(folder: Path) -> Iterator[ToyShot]:
    """Make the shot, and let this process load it, too."""
    shot = ToyShot(folder / "shot")
    before = dict(os.environ)
    os.environ.update(shot.variables)
    try:
        yield shot
    finally:
        os.environ.clear()
        os.environ.update(before)


def undisturbed(shot: ToyShot) -> Truth:
    """Run it twice, which has to give the same."""
    seen = []
    for name in ("first", "second"):
        store = shot.folder / name
        begun = time.monotonic()
        fault = shot.finish(store)
        if fault:
            raise BadInput(f"the shot itself fails: {fault}", where=shot.graph)
        seen.append(Truth(store, results(store), shot.published(), time.monotonic() - begun))
        shot.tally()
        shutil.rmtree(shot.out)
    first, second = seen
    if (first.results, first.published) != (second.results, second.published):
        raise BadInput("two runs give different bytes", where=shot.graph)
    return second


def compare(shot: ToyShot, truth: Truth, store: Path) -> str:
    """Report what differs from an undisturbed run, and remove what was published."""
    published = shot.published()
    found = results(store)
    shutil.rmtree(shot.out, ignore_errors=True)
    if published != truth.published:
        return "published other bytes"
    return "" if found == truth.results else "other results"


def try_poison(shot: ToyShot, truth: Truth, modules: tuple[str, ...]) -> list[Count]:
    """Run in a folder with a file that has the name of a module, and notes that it was executed."""
    count = Count("poisoned folder", "module in the current folder")
    for module in modules:
        place = shot.folder / f"poison-{module}"
        store = shot.folder / "poisoned"
        place.mkdir()
        flag = place / "executed"
        (place / f"{module}.py").write_text(f"open({str(flag)!r}, 'w').close()\nraise ImportError('poison')\n")
        fault = fault_of(shot.start(store, place=place))
        executed = "its code was executed" if flag.exists() else ""
        count.add(tagged(f"{module}.py", executed or fault or compare(shot, truth, store)))
        shutil.rmtree(store, ignore_errors=True)
    return [count]


def try_kills(shot: ToyShot, truth: Truth, chance: random.Random, times: int) -> list[Count]:
    """Kill runs of a shot, coordinator or all of it, at random moments; then let it end."""
    counts = [Count("kill", "coordinator"), Count("kill", "whole group")]
    for number in range(times):
        store = shot.folder / f"killed-{number}"
        which = chance.randrange(2)
        for _ in range(chance.randint(1, 3)):
            process = shot.start(store)
            time.sleep(chance.uniform(0.0, 1.2) * truth.seconds)
            with suppress(ProcessLookupError):
                (os.killpg if which else os.kill)(process.pid, signal.SIGKILL)
            process.communicate()
        there = results(store)
        shot.tally()
        fault = shot.finish(store) or compare(shot, truth, store)
        left = [path.name for path in (store / "tmp").glob("*")]
        twice = len(there.keys() & set(shot.tally()) - unsaved(there))
        counts[which].add(tagged(f"kill {number}", fault or (f"left {left}" if left else "")), twice=twice)
        shutil.rmtree(store, ignore_errors=True)
    return counts


def unsaved(there: Results) -> set[tuple[str, int | None]]:
    """Return the frames of the sum without a later state on disk, from which a killed run is continued."""
    frames = [frame for node, frame in there if node == "sum" and frame is not None]
    last = max((frame for frame in frames if frame % CHECKPOINT == 0), default=0)
    return {("sum", frame) for frame in frames if frame > last}


def flip(path: Path, chance: random.Random) -> None:
    """Flip a bit."""
    data = bytearray(path.read_bytes())
    if data:
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        path.write_bytes(data)


def cut(path: Path, chance: random.Random) -> None:
    """Cut the end off, or everything."""
    data = path.read_bytes()
    path.write_bytes(data[: chance.randrange(len(data))] if data else b"")


def plant_folder(path: Path, chance: random.Random) -> None:
    """Put a folder in its place, empty or not."""
    path.unlink()
    path.mkdir()
    if chance.randrange(2):
        (path / "within").write_text("")


def plant_json(path: Path, chance: random.Random) -> None:
    """Put JSON of somebody else there."""
    others = ("null", "3", "[]", "{}", '{"1": 5}', '{"path": "../../x", "companions": {}}', "[" * 100_000)
    path.write_text(chance.choice(others))


def remove(path: Path, chance: random.Random) -> None:
    """Remove it."""
    path.unlink()


DAMAGES = (flip, cut, plant_folder, plant_json, remove)


def try_damages(shot: ToyShot, truth: Truth, chance: random.Random, times: int, check_value: CheckValue) -> list[Count]:
    """Damage a file of a copy of a whole store, and run."""
    counts = {harm: Count("damage", (harm.__doc__ or "").rstrip(".").lower()) for harm in DAMAGES}
    kinds = sorted({path.relative_to(truth.store).parts[0] for path in files_in(truth.store)})
    for number in range(times):
        store = shot.folder / f"damaged-{number}"
        harm = DAMAGES[number % len(DAMAGES)]
        kind = chance.choice(kinds)
        shutil.copytree(truth.store, store)
        path = chance.choice([path for path in files_in(store) if path.relative_to(store).parts[0] == kind])
        path.chmod(0o644)
        harm(path, chance)
        refused = False
        try:
            fault = mend(shot, truth, store, check_value)
        except BadInput as error:
            fault = "a refusal of several lines" if "\n" in str(error) else ""
            refused = True
        except Exception as error:  # whatever it is, nobody should see it
            fault = f"{type(error).__name__}: {error}"
        counts[harm].add(tagged(f"{path.relative_to(store)} of trial {number}", fault), refused=refused)
        shutil.rmtree(shot.out, ignore_errors=True)
        shutil.rmtree(store)
    return list(counts.values())


def mend(shot: ToyShot, truth: Truth, store: Path, check_value: CheckValue) -> str:
    """Run with a damaged store, verify what no run has read, and run again; returns the violations."""
    found = None
    for _ in range(2):
        outcome = run(load_graph(shot.graph), Store(store), options=Options(jobs=1))
        fault = "; ".join(failure.message for failure in outcome.failures) or compare(shot, truth, store)
        if fault:
            return fault
        found = verify(Store(store), check_value)
    return "" if found == Found() else f"never mended: {found}"


def files_in(folder: Path) -> list[Path]:
    """List the files in a folder, and those within."""
    return sorted(path for path in folder.rglob("*") if path.is_file())


def try_cleanings(shot: ToyShot, truth: Truth, chance: random.Random, times: int) -> list[Count]:
    """Clean a store of everything, at random moments, while two runs share it."""
    count = Count("cleaning", "during two runs")
    for number in range(times):
        store = shot.folder / f"shared-{number}"
        if chance.randrange(2):
            shutil.copytree(truth.store, store)
        runs = [shot.start(store, jobs=1) for _ in range(2)]
        for _ in range(chance.randint(1, 6)):
            time.sleep(chance.uniform(0.0, 0.5) * truth.seconds)
            clean(Store(store))
        faults = [fault for fault in map(fault_of, runs) if fault]
        published = "" if shot.published() == truth.published else "published other bytes"
        fault = "; ".join(faults) or published or shot.finish(store) or compare(shot, truth, store)
        count.add(tagged(f"trial {number}", fault))
        shutil.rmtree(shot.out, ignore_errors=True)
        shutil.rmtree(store)
    return [count]


def tagged(label: str, fault: str) -> str:
    """Echo of which trial a fault is."""
    return f"{label}: {fault}" if fault else ""
