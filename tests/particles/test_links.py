"""Links join neighbours along the hair, and all particles to roots."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from hairpipe.errors import BadInput
from hairpipe.particles.links import find_links, link, reach_with
from hairpipe.particles.sampling import sample
from hairpipe.particles.settings import Fibre


@pytest.mark.parametrize("sampling", ["strands", "even"])
def test_all_are_linked_to_roots_with_about_the_requested_number_of_links(curtain, rule, sampling):
    particles = link(sample(curtain, 500, sampling, 0), rule, Fibre().line_density)
    count, deep = len(particles.points), int(np.count_nonzero(particles.arcs < 0.0))
    led = np.bincount(particles.links[:, 1], minlength=count)
    assert led[deep:].min() >= 1
    graph = coo_array((np.ones(len(particles.links)), particles.links.T), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    assert np.isin(labels, labels[:deep]).all()
    each = np.bincount(particles.links.ravel(), minlength=count)[deep:]
    assert 12.0 <= each.mean() <= 13.0 and each.max() <= 30
    assert particles.masses[deep:].sum() == pytest.approx(Fibre().line_density * 0.2 * 1000)


def test_alignments_are_those_of_the_paper_and_at_least_as_asked(particles):
    i, j = particles.links.T
    way = particles.points[j] - particles.points[i]
    way /= np.linalg.norm(way, axis=1)[:, None]
    here, there = np.sum(particles.directions[i] * way, axis=1), np.sum(particles.directions[j] * -way, axis=1)
    assert (here * there < 0.0).all() and (here > 0.0).all()
    assert particles.alignments == pytest.approx(np.abs(here - there) / 2.0)
    assert particles.alignments.min() >= 0.5


def test_reaches_have_the_requested_neighbours():
    points = np.random.default_rng(1).uniform(size=(1500, 3))
    h = reach_with(points, 30.0)
    counts = [len(near) - 1 for near in KDTree(points).query_ball_point(points, 2.0 * h)]
    assert np.mean(counts) == pytest.approx(30.0, rel=1e-2)


def test_too_few_particles_and_loose_ones_are_refused(curtain, rule):
    with pytest.raises(BadInput, match=r"cannot have 58 neighbours each \(more than 58\)"):
        link(sample(curtain, 30, "strands", 0), rule, 1e-5)
    points = np.array([[0.0, 0.0, 0.0], [0.0, -0.01, 0.0], [1.0, 0.0, 0.0], [1.0, -0.01, 0.0]])
    with pytest.raises(BadInput, match="2 of 3 particles are not linked to a root"):
        find_links(points, np.tile([0.0, -1.0, 0.0], (4, 1)), 1, 0.01, rule)
