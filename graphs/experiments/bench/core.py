"""Cost of the strand core, compared with the limits of the machine."""

from collections.abc import Callable
from itertools import product
from typing import get_args

import numba

from hairpipe.graphs.experiments.bench.arithmetic.assembly import count_arithmetic
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work
from hairpipe.graphs.experiments.bench.repeat import Spread, repeat
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, make_report
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
from hairpipe.strands.registry import ModelName

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


CACHED, STORED = 256, 9_712
"""Strands whose state stays in the cache; whose state does not: a million particles at 50 segments."""


def measure_core(
    echo: Echo, segments: int = 50, cached: int = CACHED, stored: int = STORED, triad: int = TRIAD, seconds: float = 2.0
) -> Report:
    """Measure every case, and report progress.

    segments        of a strand
    cached, stored  strands whose state stays in the cache, whose state does not
    triad           numbers in each array of the triad
    seconds         that every measurement is repeated
    """
    threads = [count for count in THREADS if count <= numba.get_num_threads()]
    echo("multiply-adds and the triad")
    roofs = measure_roofs(DTYPES, threads, triad, seconds)
    echo("reading machine code")
    work: dict[tuple[ModelName, str], Work] = {
        (model, dtype): work_of_a_solve(segments, dtype, model) for model in MODELS for dtype in DTYPES
    }
    cases = list[Case]()
    for (place, strands), dtype, model in product([("cache", cached), ("memory", stored)], DTYPES, MODELS):
        echo(f"{strands:,} strands of the {model} in {dtype}")
        hair = hang(strands, segments, dtype, model)
        for count, kernel in product(threads, KERNELS):
            spent = _time(KERNELS[kernel], hair, count, seconds)
            case: Case = {"kernel": kernel, "model": model, "in": place, "numbers": dtype, "threads": count}
            case |= spent.columns(" [ns a particle]")
            case["each segment [ns]"] = spent.median * particles_of(model, segments) / segments
            if kernel == "solve":
                case["floor [ns a particle]"] = least_time(work[model, dtype], dtype, place, count, roofs)
                case["prototype [ns a particle]"] = PROTOTYPE.get((place, dtype, count)) if model == "network" else None
            cases.append(case)
    solves = [solve_case(model, dtype, each) for (model, dtype), each in work.items()]
    tables = {"kernels": cases, "solves": solves, "limits": roofs.cases}
    return make_report(__name__, tables, roofs.bandwidth)


def solve_case(model: ModelName, dtype: str, work: Work) -> Case:
    """Describe a solve: its work for each particle, and instructions of arithmetic in its machine code, by vector."""
    code = count_arithmetic(machine_code(dtype, model).splitlines())
    rates: Case = {"flop a particle": work.operations, "bytes a particle": work.bytes}
    return {"model": model, "numbers": dtype, **rates, **code._asdict()}


def least_time(work: Work, dtype: str, place: str, threads: int, roofs: Roofs) -> float:
    """Return the least time per particle of work [ns]: for its arithmetic, or for moving its numbers from memory."""
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
