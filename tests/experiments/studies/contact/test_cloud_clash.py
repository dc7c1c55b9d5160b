"""A bar and a tuft of particles: a slow one goes through nothing, one that jumps over them does."""

import pytest

from hairpipe.graphs.experiments.studies.contact.bar import tuft
from hairpipe.graphs.experiments.studies.contact.cloud_clash import meet
from hairpipe.particles.links import LinkRule, link
from hairpipe.particles.sampling import sample
from hairpipe.particles.settings import Interaction, ParticleSettings, RestTension

SETTINGS = ParticleSettings(interaction=Interaction(), sag_free=RestTension())


@pytest.fixture(scope="module")
def particles():
    return link(sample(tuft(), 240, "strands", 0), LinkRule(12, 0.5, 58.0, 24.0), SETTINGS.fibre.line_density)


def test_a_slow_bar_goes_through_no_hair_and_has_none_inside(particles):
    worst = meet(particles, SETTINGS, 0.5, 120, 0.2)
    assert worst.finite and worst.steps == 24 and not worst.through.any()
    assert worst.deepest < 1e-4 and worst.stretch > 0.0


def test_a_bar_that_goes_ten_times_its_radius_in_a_frame_goes_through(particles):
    worst = meet(particles, SETTINGS, 8.0, 24, 0.25)
    assert worst.finite and worst.through.any()
