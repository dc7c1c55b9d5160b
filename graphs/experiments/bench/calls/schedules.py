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

from hairpipe.bench.report import Case, Echo, Report, make_report
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

FRAMES = 3
CHANCES = (0.02, 0.1, 0.5)
"""Of a turn to end at a call."""
REPORTED = 500
"""Number of schedules after which progress is reported."""


class Turns:
    """Threads of which one runs at a time; which one is drawn.

    chance  of a turn to end at a call
    """

    def __init__(self, draw: random.Random, chance: float) -> None:
        self._draw, self._chance = draw, chance
        self._waiting: dict[int, threading.Semaphore] = {}

    def join(self, thread: int) -> None:
        """Add a thread that does not run yet."""
        self._waiting[thread] = threading.Semaphore(0)

    def start(self) -> None:
        """Give the first turn."""
        self._waiting[self._drawn()].release()

    def wait(self, thread: int) -> None:
        """Wait for a turn."""
        self._waiting[thread].acquire()

    def step(self, thread: int) -> None:
        """Perhaps let another thread run."""
        if self._draw.random() < self._chance and (other := self._drawn()) != thread:
            self._waiting[other].release()
            self.wait(thread)

    def leave(self, thread: int) -> None:
        """End a thread."""
        del self._waiting[thread]
        if self._waiting:
            self.start()

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
    threads: dict[int, int] = {}
    order: list[int] = []
    made = Counter[int]()

    def before(call: Call) -> None:
        scene.processes.check()
        thread = threads[threading.get_ident()]
        order.append(thread)
        made[thread] += 1
        if thread == 0 and made[0] - 1 == killed_at:
            scene.processes.kill()
        turns.step(thread)

    def work(thread: int) -> None:
        threads[threading.get_ident()] = thread
        turns.wait(thread)
        try:
            endings[thread] = scene.run_in_thread()
        finally:
            turns.leave(thread)

    with patch.dict(SOURCES, clear=True), FileLayer((scene.store, scene.shot.out), before):
        workers = [threading.Thread(target=work, args=(thread,)) for thread in range(2)]
        for thread, worker in enumerate(workers):
            turns.join(thread)
            worker.start()
        turns.start()
        for worker in workers:
            worker.join()
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
