"""Cost of the strand core, compared with the limits of the machine."""

import subprocess
import tempfile
import time
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import NamedTuple, get_args

import numba

from hairpipe.bench.machine import Machine, this_machine
from hairpipe.child import command, environment
from hairpipe.graphs.experiments.bench.arithmetic.assembly import Arithmetic, count_arithmetic
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work
from hairpipe.graphs.experiments.bench.repeat import Spread, repeat
from hairpipe.graphs.experiments.bench.roofs import TRIAD, Roofs, measure_roofs
from hairpipe.graphs.experiments.bench.strands import (
    Strands,
    hang,
    machine_code,
    particles_of,
    solve,
    step,
    work_of_a_solve,
)
from hairpipe.sim.strands.registry import ModelName

MODELS: tuple[ModelName, ...] = get_args(ModelName)
DTYPES = ("float32", "float64")
THREADS = (1, 2)
KERNELS = {"solve": solve, "step": step}
PROTOTYPE = {
    ("cache", "float32", 1): 20.0,
    ("cache", "float64", 1): 40.0,
    ("memory", "float32", 1): 38.4,
    ("memory", "float32", 2): 19.8,
    ("memory", "float64", 1): 74.2,
    ("memory", "float64", 2): 37.6,
}
"""What a throw-away prototype took for a solve of the network on a Zen 4 core, per particle [ns]."""
_RUN = ("run", "demo", "-q", "-j1", "--to", "hair", "--frames", "1001-1002", "--set", "groom.strands=8")
_MAIN = "from hairpipe.cli import main; sys.argv[1:] = {!r}; main()"


class Sizes(NamedTuple):
    """What is measured, and for how long.

    segments  of a strand
    cache     strands whose state stays in the cache
    memory    strands whose state does not: a million particles at 50 segments
    triad     numbers in each array of the triad
    seconds   that every measurement is repeated
    """

    segments: int = 50
    cache: int = 256
    memory: int = 9_712
    triad: int = TRIAD
    seconds: float = 2.0


FULL = Sizes()


class Case(NamedTuple):
    """One kernel in one place; times are per particle [ns].

    kernel     solve: one linearly implicit stage; step: one step of the default integrator
    model      of a strand
    place      cache or memory
    floor      the least time of a solve on this machine
    prototype  what the prototype took
    segment    time per segment of a strand
    """

    kernel: str
    model: str
    place: str
    dtype: str
    threads: int
    time: Spread
    floor: float | None
    prototype: float | None
    segment: float


class Report(NamedTuple):
    """All of it.

    work      of a solve, per particle, by model and dtype
    code      arithmetic in the machine code of a solve, by model and dtype
    compiled  time until every kernel of a frame of hair is compiled, nothing being warm [s]
    """

    machine: Machine
    sizes: Sizes
    roofs: Roofs
    work: dict[str, dict[str, Work]]
    code: dict[str, dict[str, Arithmetic]]
    cases: list[Case]
    compiled: float


def measure_core(say: Callable[[str], None], sizes: Sizes = FULL) -> Report:
    """Measure every case, and report progress."""
    threads = [count for count in THREADS if count <= numba.get_num_threads()]
    say("compiling every kernel with an empty cache")
    compiled = measure_compilation()
    say("multiply-adds and the triad")
    roofs = measure_roofs(DTYPES, threads, sizes.triad, sizes.seconds)
    say("reading machine code")
    work = {model: {dtype: work_of_a_solve(sizes.segments, dtype, model) for dtype in DTYPES} for model in MODELS}
    code = {
        model: {dtype: count_arithmetic(machine_code(dtype, model).splitlines()) for dtype in DTYPES}
        for model in MODELS
    }
    cases, places = [], [("cache", sizes.cache), ("memory", sizes.memory)]
    for (place, strands), dtype, model in product(places, DTYPES, MODELS):
        say(f"{strands:,} strands of the {model} in {dtype}")
        hair = hang(strands, sizes.segments, dtype, model)
        share = particles_of(model, sizes.segments) / sizes.segments
        for count, kernel in product(threads, KERNELS):
            spent, solves = _time(KERNELS[kernel], hair, count, sizes.seconds), kernel == "solve"
            floor = least_time(work[model][dtype], dtype, place, count, roofs) if solves else None
            prototype = PROTOTYPE.get((place, dtype, count)) if solves and model == "network" else None
            cases.append(Case(kernel, model, place, dtype, count, spent, floor, prototype, share * spent.median))
    return Report(this_machine(), sizes, roofs, work, code, cases, compiled)


def measure_compilation() -> float:
    """Find the time to compile every kernel from groom to hair, body and level set too [s]: two frames of the demo.

    A fresh process runs them with an empty cache for results, first without kernels and then with those it left.
    """
    with tempfile.TemporaryDirectory() as folder:
        kernels = environment() | {"NUMBA_CACHE_DIR": str(Path(folder, "kernels"))}
        times = []
        for cache in ("first", "second"):
            begun = time.perf_counter()
            words = [*_RUN, "--cache", str(Path(folder, cache))]
            subprocess.run(command(_MAIN.format(words)), env=kernels, check=True)
            times.append(time.perf_counter() - begun)
    return times[0] - times[1]


def least_time(work: Work, dtype: str, place: str, threads: int, roofs: Roofs) -> float:
    """Give the least time per particle of some work [ns]: for its arithmetic, or for moving its numbers from memory."""
    arithmetic = work.operations / (roofs.multiply_add[dtype].median * threads)
    moving = work.bytes / roofs.triad[threads].median if place == "memory" else 0.0
    return 1e9 * max(arithmetic, moving)


def _time(kernel: Callable[[Strands], None], hair: Strands, threads: int, seconds: float) -> Spread:
    """Time a kernel per particle [ns]."""
    before = numba.get_num_threads()
    numba.set_num_threads(threads)
    try:
        return repeat(lambda: kernel(hair), seconds, hair.restart).per(hair.particles * 1e-9)
    finally:
        numba.set_num_threads(before)
