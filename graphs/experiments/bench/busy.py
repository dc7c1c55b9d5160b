"""Cost of hair next to other programs: frames alone, and while other processes take the cores."""

import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from hairpipe.child import command
from hairpipe.graphs.experiments.bench.machine import share_kernels
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report

HAIRS = (60, 1_000, 10_000)
BUSY = (0, 1, 2, 4)
"""Numbers of processes that compute next to the hair."""
BEFORE, FRAMES = 2, 5
"""Frames before the first that is measured, which load kernels, and measured ones."""
_FRAMES = "from hairpipe.graphs.experiments.bench import busy; busy.print_frames({hairs}, {before}, {frames})"
_COMPUTE = "import os\nparent = os.getppid()\nwhile os.getppid() == parent: pass"
"""Compute for as long as the process that began this lives, also where that is killed."""


def measure_busy(
    echo: Echo, hairs: Sequence[int] = HAIRS, busy: Sequence[int] = BUSY, before: int = BEFORE, frames: int = FRAMES
) -> Report:
    """Measure every case, each in a process of its own, and report progress.

    hairs   numbers of hairs of 50 segments that stick and collide, on our bust, which turns to and fro
    busy    numbers of processes that compute without end meanwhile
    before  frames before the first that is measured
    frames  measured ones
    """
    cases: list[Case] = []
    for count in hairs:
        alone: tuple[float, float] | None = None
        for others in busy:
            echo(f"{count:,} hairs next to {others} busy processes")
            with computing(others):
                wall, processor = median_frame(count, before, frames)
            alone = alone or (wall, processor)
            case: Case = {"hairs": count, "busy processes": others, "frame [s]": wall, "processor [s]": processor}
            cases.append(case | {"frame to first": wall / alone[0], "processor to first": processor / alone[1]})
    return make_report(__name__, {"busy": cases})


def median_frame(hairs: int, before: int, frames: int) -> tuple[float, float]:
    """Return the medians of a frame: time that passes, and of processors [s]."""
    code = _FRAMES.format(hairs=hairs, before=before, frames=frames)
    done = subprocess.run(command(code), stdout=subprocess.PIPE, check=True)
    found = json.loads(done.stdout)
    wall, processor = (sorted(times)[len(times) // 2] for times in zip(*found, strict=True))
    return wall, processor


def print_frames(hairs: int, before: int, frames: int) -> None:
    """Simulate frames in this process; print of each the time that passes, and of processors [s]."""
    share_kernels()
    from hairpipe.graphs.experiments.bench.head import SEGMENTS, grow_head

    head = grow_head(hairs * SEGMENTS, "pairs")
    found = []
    for frame in range(before + frames):
        surroundings = head.surroundings()
        begun = time.perf_counter(), time.process_time()
        head.advance(surroundings)
        if frame >= before:
            found.append((time.perf_counter() - begun[0], time.process_time() - begun[1]))
    json.dump(found, sys.stdout)


@contextmanager
def computing(processes: int) -> Iterator[list[subprocess.Popen]]:
    """Let processes compute without end, each on one core, until the context ends."""
    others = [subprocess.Popen([sys.executable, "-c", _COMPUTE]) for _ in range(processes)]
    try:
        yield others
    finally:
        for other in others:
            other.kill()
        for other in others:
            other.wait()
