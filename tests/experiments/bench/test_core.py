"""Reports on parts: kernels of strands, roofs of the machine, volume, particles."""

import platform

import numba
import numpy as np
import pytest

from hairpipe.geometry.simd import width
from hairpipe.graphs.experiments.bench import core, machine, particles, roofs, volume
from hairpipe.graphs.experiments.bench.arithmetic.assembly import assembly_of, count_arithmetic
from hairpipe.graphs.experiments.bench.arithmetic.counting import Work
from hairpipe.graphs.experiments.bench.particles import link_pass, measure_particles
from hairpipe.graphs.experiments.bench.repeat import LEAST_RUNS, Spread, repeat
from hairpipe.graphs.experiments.bench.roofs import Roofs
from hairpipe.values.groom import strand_lengths

TINY = {"segments": 4, "cached": 9, "stored": 17, "triad": 1 << 12, "seconds": 0.0}


def test_the_least_time_is_that_of_the_tighter_roof():
    """On 1e9 operations and 2e9 bytes a second, and twice the operations with two threads."""
    roofs = Roofs({"float64": Spread(1e9, 1e9, 1e9, 1)}, {n: Spread(2e9, 2e9, 2e9, 1) for n in (1, 2)})
    work = Work(operations=100, bytes=300)
    assert core.least_time(work, "float64", "cache", 1, roofs) == pytest.approx(100)
    assert core.least_time(work, "float64", "cache", 2, roofs) == pytest.approx(50)
    assert core.least_time(work, "float64", "memory", 1, roofs) == pytest.approx(150)


def test_every_case_is_measured_once(monkeypatch):
    monkeypatch.setattr(core, "MODELS", ("network",))  # others would be compiled for nothing else
    reported = []
    before = numba.get_num_threads()
    report = core.measure_core(reported.append, **TINY)
    assert numba.get_num_threads() == before
    threads = [n for n in core.THREADS if n <= before]
    kernels = report.tables["kernels"]
    cases = [tuple(case[name] for name in ("kernel", "in", "numbers", "threads")) for case in kernels]
    assert len(set(cases)) == len(cases) == 2 * 2 * 2 * len(threads)
    for case in kernels:
        median, low, high = (case[f"{name} [ns a particle]"] for name in ("median", "low", "high"))
        assert 0 < low <= median <= high and case["each segment [ns]"] == pytest.approx(median * 11 / 4)
        assert ("floor [ns a particle]" in case) == (case["kernel"] == "solve")
    single, double = report.tables["solves"]
    assert double["flop a particle"] == single["flop a particle"]
    assert double["bytes a particle"] == 2 * single["bytes a particle"]
    assert report.machine.cores >= 1
    assert report.bandwidth > 0 and len(report.tables["limits"]) == 2 + len(threads)
    assert "17 strands of the network in float32" in reported


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_the_chains_converge_to_what_they_iterate(dtype):
    """y = y / 2 + 1 goes to 2; four chains are added to each of two sums."""
    start = np.zeros((roofs.CHAINS, width(dtype)), dtype)
    roofs._chain(start, 0.5, 1.0, 200)
    np.testing.assert_allclose(start[:2], 8.0, rtol=1e-6)


def test_all_of_the_chains_are_vectors():
    code = count_arithmetic(assembly_of(roofs._chain, np.zeros((8, 8)), 0.5, 1.0, 10).splitlines())
    assert code.packed == 1.0 and sum(code) >= roofs.CHAINS


def test_the_first_run_and_preparing_do_not_count(monkeypatch):
    calls, clock = [], [0]

    def work():
        calls.append("work")
        clock[0] += 2000 if len(calls) <= 2 else len(calls) // 2

    def prepare():
        calls.append("prepare")
        clock[0] += 100

    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    spread = repeat(work, 0.0, prepare)
    assert calls == ["prepare", "work"] * (LEAST_RUNS + 1)
    assert spread == Spread(median=4.0, low=3.0, high=5.0, runs=LEAST_RUNS)


def test_a_time_becomes_a_time_per_thing_or_a_rate():
    spread = Spread(2.0, 1.0, 4.0, 7)
    assert spread.per(2) == (1.0, 0.5, 2.0, 7)
    assert spread.rate(8) == (4.0, 2.0, 8.0, 7)
    assert spread.rate(8).low == pytest.approx(8 / spread.high)


CPUINFO = """processor	: 0
vendor_id	: AuthenticAMD
cpu family	: 25
model		: 17
model name	: AMD EPYC

processor	: 1
cpu family	: 26
model		: 2
model name	: another
"""


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (CPUINFO, "AMD EPYC family 25 model 17"),
        ("model name	: Some Processor\n", "Some Processor"),
        ("", platform.processor() or platform.machine()),
    ],
)
def test_a_processor_is_named_with_its_generation(text, name, monkeypatch, tmp_path):
    (tmp_path / "cpuinfo").write_text(text)
    monkeypatch.setattr(machine, "Path", lambda path: tmp_path / "cpuinfo")
    assert machine.this_machine().processor == name


def test_every_case_of_the_volume_is_measured_once():
    before, reported = numba.get_num_threads(), []
    report = volume.measure_volume(reported.append, hairs=200, segments=6, every=2, seconds=0.0)
    assert numba.get_num_threads() == before and reported == ["100 hairs on a grid", "200 hairs between 100 keys"]
    threads = [n for n in volume.THREADS if n <= before]
    kernels = ("grid", "pressure", "interpolate")
    assert [(case["kernel"], case["threads"]) for case in report.tables["kernels"]] == [
        (name, n) for name in kernels for n in threads
    ]
    assert all(0 < case["low [ns]"] <= case["median [ns]"] <= case["high [ns]"] for case in report.tables["kernels"])


def test_hair_is_as_long_as_it_says():
    groom = volume.scattered_hair(5, 7)
    assert strand_lengths(groom.points, groom.offsets) == pytest.approx(np.full(5, volume.LENGTH))


def test_every_case_is_measured_on_one_thread_and_its_parts_are_less_than_all_of_it():
    before, reported = numba.get_num_threads(), []
    report = measure_particles(reported.append, counts=(150,), steps=(1, 2), settling=0, frames=1)
    assert numba.get_num_threads() == before and reported == ["a head, frames: 1", "150 particles"]
    one, two = report.tables["frames"]
    assert (one["steps"], two["steps"]) == (1, 2) and one["iterations"] < two["iterations"]
    assert abs(one["particles"] - 150) < 10 and one["pairs"] > one["particles"] < one["links"] / 5
    for case, parts in zip(report.tables["frames"], report.tables["parts"], strict=True):
        assert 0.0 < case["least [ms]"] <= case["median [ms]"]
        assert [*parts] == ["particles", "steps", *(f"{part} [ms]" for part in particles.PARTS)]
        assert all(0.0 < parts[f"{part} [ms]"] < 10.0 * case["median [ms]"] for part in particles.PARTS)


def test_a_link_pass_takes_nanoseconds():
    assert 1e-10 < link_pass() < 1e-6
