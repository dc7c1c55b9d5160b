"""The modulus of the hair is held while links fade."""

import numpy as np
import pytest

from hairpipe.particles.links import measure_links, stiffen
from hairpipe.particles.model import build_model, kernel


@pytest.fixture
def model(particles):
    return build_model(particles)


def stiffness_at(model, points, axial=0.1):
    ways, stiffness = np.empty((len(model.links.ends), 4)), np.empty(len(model.links.ends))
    measure_links(model.links, points, ways)
    stiffen(model.links, model.reach, np.full(len(points), axial), ways, stiffness)
    return stiffness


def test_stiffness_is_the_mean_of_the_shares_of_both_ends(particles, model):
    """(7) and (10) to (14) as printed, which are the same where nothing is out of reach."""
    i, j = particles.links.T
    points, lengths, reach = particles.points, model.links.lengths, particles.reach
    k = particles.alignments * lengths * kernel(lengths, reach)
    tip, root = np.zeros(len(points)), np.zeros(len(points))
    np.add.at(tip, i, lengths * k)
    np.add.at(root, j, lengths * k)
    alpha = 0.5 * (0.1 / tip[i] + 0.1 / root[j])
    assert stiffness_at(model, points) == pytest.approx(alpha * k, rel=1e-12)
    sums = np.zeros(len(points))
    np.add.at(sums, j, lengths * alpha * k)
    assert 1.0 <= sums[model.deep :].mean() / 0.1 <= 1.2


def test_no_link_is_stiffer_than_all_of_the_hair_wherever_particles_are(particles, model):
    rng = np.random.default_rng(0)
    for spread in (0.2, 1.0, 3.0, 10.0):
        points = particles.points + spread * particles.reach * rng.normal(size=particles.points.shape)
        stiffness = stiffness_at(model, points)
        assert np.isfinite(stiffness).all() and (stiffness >= 0.0).all()
        assert (stiffness <= 0.1 / model.links.lengths * (1.0 + 1e-12)).all()


def test_torn_apart_each_particle_keeps_one_link_to_the_root_and_no_other(particles, model):
    """The others fade beyond 2 h, so what was pulled off is pulled back."""
    far = particles.points * 1e3
    kept = np.flatnonzero(stiffness_at(model, far) > 0.0)
    assert sorted(particles.links[kept, 1]) == sorted(set(particles.links[:, 1]))


def test_all_in_one_place_is_finite(particles, model):
    assert np.isfinite(stiffness_at(model, np.zeros_like(particles.points))).all()
