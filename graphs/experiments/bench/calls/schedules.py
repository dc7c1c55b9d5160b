"""Two coordinators of one shot, which take turns at every call of the file system in an order that a seed gives.

In half of the schedules one of them is killed at some call. Another process then runs the shot to its end.
"""

import itertools
import os
import random
import tempfile
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

from hairpipe.graphs.experiments.bench.calls.call_trials import (
    LOST,
    MEMORY,
    SOURCES,
    Ending,
    Scene,
    left_over,
    undisturbed,
)
from hairpipe.graphs.experiments.bench.calls.file_layer import Call, FileLayer
from hairpipe.graphs.experiments.bench.calls.simulation import Processes, simulated
from hairpipe.graphs.experiments.bench.machines.end_state import CheckValue, differences, state_of
from hairpipe.graphs.experiments.bench.machines.trials import Truth
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

FRAMES = 3
CHANCES = (0.02, 0.1, 0.5)
"""Of a turn to end at a call."""
REPORTED = 500
"""Number of schedules after which progress is reported."""


class Turns:
    """Threads of which one runs at a time; which one is drawn.

    chance   of a turn to end at a step
    current  number of the thread that runs
    """

    def __init__(self, draw: random.Random, chance: float) -> None:
        self._draw, self._chance = draw, chance
        self._waiting: dict[int, threading.Semaphore] = {}
        self.current = 0

    def run(self, work: Callable[[int], None], count: int) -> None:
        """Call `work` with each number below a count, in a thread each, and wait for their ends."""

        def take_turns(thread: int) -> None:
            self._wait(thread)
            try:
                work(thread)
            finally:
                del self._waiting[thread]
                if self._waiting:
                    self._waiting[self._drawn()].release()

        self._waiting = {thread: threading.Semaphore(0) for thread in range(count)}
        threads = [threading.Thread(target=take_turns, args=(thread,)) for thread in range(count)]
        for thread in threads:
            thread.start()
        self._waiting[self._drawn()].release()
        for thread in threads:
            thread.join()

    def step(self) -> None:
        """Perhaps let another thread run."""
        thread = self.current
        if self._draw.random() < self._chance and (other := self._drawn()) != thread:
            self._waiting[other].release()
            self._wait(thread)

    def _wait(self, thread: int) -> None:
        self._waiting[thread].acquire()
        self.current = thread

    def _drawn(self) -> int:
        return self._draw.choice(sorted(self._waiting))


def try_schedules(echo: Echo, check_value: CheckValue, seeds: range) -> Report:
    """Try the schedules of some seeds."""
    with tempfile.TemporaryDirectory(prefix="hairpipe-schedules-", dir=MEMORY) as name:
        processes = Processes()
        scene = Scene(Path(name).resolve(), processes, FRAMES)
        with simulated(processes), patch.dict(os.environ, scene.shot.variables):
            calls, truth = undisturbed(scene, check_value)
            echo(f"a run alone makes {len(calls)} calls")
            cases = []
            for seed in seeds:
                cases.append(try_schedule(scene, seed, len(calls), truth, check_value))
                if cases[-1]["violation"]:
                    echo(f"seed {seed}: {cases[-1]['violation']}")
                if len(cases) % REPORTED == 0:
                    echo(f"{len(cases)} of {len(seeds)} schedules")
    violations = [case for case in cases if case["violation"]]
    return make_report(__name__, {"schedules": summary(cases), "violations": violations})


def try_schedule(scene: Scene, seed: int, calls: int, truth: Truth, check_value: CheckValue) -> Case:
    """Try the schedule of a seed."""
    draw = random.Random(seed)
    turns = Turns(draw, draw.choice(CHANCES))
    killed_at = draw.randrange(calls) if draw.random() < 0.5 else None
    scene.clear()
    endings, shared = run_two(scene, turns, killed_at)
    violations = [f"{ending.way}: {ending.message}" for ending in endings if ending.way not in ("", "killed")]
    again = scene.run(lambda call: None)
    if again.way:
        violations.append(f"the next run: {again.way}: {again.message}")
    extra = scene.shot.count() - truth.evaluations
    if not 0 <= extra <= (0 if killed_at is None else LOST):
        violations.append(f"{extra} evaluations more than undisturbed")
    violations += differences(state_of(scene.store, scene.shot.out, check_value), truth.state)
    violations += [f"{path.parent.name}/{path.name} is left" for path in left_over(scene)]
    return {
        "seed": seed,
        "killed at": killed_at,
        "turns": shared,
        "evaluated again": extra,
        "violation": "; ".join(violations),
    }


def run_two(scene: Scene, turns: Turns, killed_at: int | None) -> tuple[list[Ending], int]:
    """Run the shot in two processes; how they ended, and the number of turns. The first one may be killed at a call."""
    endings: dict[int, Ending] = {}
    order: list[int] = []
    made = Counter[int]()

    def before(call: Call) -> None:
        scene.processes.check()
        order.append(turns.current)
        made[turns.current] += 1
        if turns.current == 0 and made[0] - 1 == killed_at:
            scene.processes.kill()
        turns.step()

    def work(thread: int) -> None:
        endings[thread] = scene.run_in_thread()

    with patch.dict(SOURCES, clear=True), FileLayer((scene.store, scene.shot.out), before):
        turns.run(work, 2)
    return [endings[thread] for thread in sorted(endings)], sum(a != b for a, b in itertools.pairwise(order))


def summary(cases: list[Case]) -> list[Case]:
    """Sum up the schedules with and without a kill."""
    groups: dict[str, Callable[[Case], bool]] = {
        "two coordinators": lambda case: case["killed at"] is None,
        "one of them killed": lambda case: case["killed at"] is not None,
    }
    chosen = {title: [case for case in cases if belongs(case)] for title, belongs in groups.items()}
    return [
        {
            "schedules": title,
            "number": len(found),
            "turns at most": max(int(case["turns"] or 0) for case in found),
            "evaluated again at most": max(int(case["evaluated again"] or 0) for case in found),
            "violations": sum(case["violation"] != "" for case in found),
        }
        for title, found in chosen.items()
        if found
    ]
