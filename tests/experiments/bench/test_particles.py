"""The report on hair of particles."""

import numba

from hairpipe.graphs.experiments.bench import particles
from hairpipe.graphs.experiments.bench.particles import link_pass, measure_particles


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
