"""The report on hair of particles."""

import numba

from hairpipe.graphs.experiments.bench import particles
from hairpipe.graphs.experiments.bench.particles import Sizes, link_pass, measure_particles


def test_every_case_is_measured_on_one_thread_and_its_parts_are_less_than_all_of_it():
    before, said = numba.get_num_threads(), []
    report = measure_particles(said.append, Sizes(counts=(150,), steps=(1, 2), settling=0, frames=1))
    assert numba.get_num_threads() == before and said == ["a head, frames: 1", "150 particles"]
    one, two = report.cases
    assert (one.steps, two.steps) == (1, 2) and one.iterations < two.iterations
    assert abs(one.particles - 150) < 10 and one.links > 5 * one.particles and one.pairs > one.particles
    for case in report.cases:
        assert 0.0 < case.least <= case.median and tuple(case.shares) == particles.PARTS
        assert not [part for part in case.shares.items() if not 0.0 < part[1] < 10.0 * case.median]


def test_a_link_pass_takes_nanoseconds():
    assert 1e-10 < link_pass() < 1e-6
