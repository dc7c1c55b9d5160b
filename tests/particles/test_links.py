"""Links: whom they join, how stiff they are, what they carry, and the directions that follow them."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from hairpipe.errors import BadInput
from hairpipe.particles.links import find_links, link, measure_links, reach_with, redirect, stiffen
from hairpipe.particles.model import build_model, kernel
from hairpipe.particles.sampling import sample
from hairpipe.particles.settings import Fibre
from hairpipe.particles.simulate import rest_lengths

from .conftest import RULE


@pytest.mark.parametrize("sampling", ["strands", "even"])
def test_all_are_linked_to_roots_with_about_the_requested_number_of_links(curtain, sampling):
    particles = link(sample(curtain, 500, sampling, 0), RULE, Fibre().line_density)
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


def test_too_few_particles_and_loose_ones_are_refused(curtain):
    with pytest.raises(BadInput, match=r"cannot have 58 neighbours each \(more than 58\)"):
        link(sample(curtain, 30, "strands", 0), RULE, 1e-5)
    points = np.array([[0.0, 0.0, 0.0], [0.0, -0.01, 0.0], [1.0, 0.0, 0.0], [1.0, -0.01, 0.0]])
    with pytest.raises(BadInput, match="2 of 3 particles are not linked to a root"):
        find_links(points, np.tile([0.0, -1.0, 0.0], (4, 1)), 1, 0.01, RULE)


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


def test_link_tensions_balance_gravity(particles):
    """But for the softness that was added, and what could not be had within the strain."""
    model, points = build_model(particles), particles.points
    axial = np.full(len(points), 9.81 * model.hang / 0.1)
    rest = rest_lengths(model, points, axial, 9.81, 0.9)
    ways, stiffness = np.empty((len(rest), 4)), np.empty(len(rest))
    measure_links(model.links, points, ways)
    stiffen(model.links, model.reach, axial, ways, stiffness)
    tensions, force = stiffness * (ways[:, 3] - rest), np.zeros_like(points)
    np.add.at(force, model.links.ends[:, 0], tensions[:, None] * ways[:, :3])
    np.add.at(force, model.links.ends[:, 1], -tensions[:, None] * ways[:, :3])
    weight = 9.81 * model.masses[:, None] * (0.0, 1.0, 0.0)
    off = np.linalg.norm((force - weight)[model.deep :], axis=1) / weight[0, 1]
    assert np.median(off) < 0.02 and off.mean() < 0.05


def test_no_length_changes_by_more_than_is_allowed(particles):
    model = build_model(particles)
    axial = np.full(len(particles.points), 0.1 * 9.81 * model.hang)
    rest = rest_lengths(model, particles.points, axial, 9.81, 0.3)
    assert np.abs(rest / model.links.lengths - 1.0).max() == pytest.approx(0.3)


def turned(model, points, directions):
    directions = directions.copy()
    redirect(
        model.links,
        model.reach,
        np.full(len(points), 0.1),
        model.deep,
        points,
        np.empty(len(model.links.ends)),
        directions,
    )
    return directions


def test_at_rest_they_stay_and_turned_with_all_the_hair_they_turn_with_it(particles):
    model, rng = build_model(particles), np.random.default_rng(4)
    directions = particles.directions + 0.2 * rng.normal(size=particles.directions.shape)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    same = turned(model, particles.points, particles.directions)
    assert same == pytest.approx(particles.directions, abs=1e-9)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    once = turned(model, particles.points, directions)
    both = turned(model, particles.points @ turn.T, directions @ turn.T)
    assert both[model.deep :] == pytest.approx((once @ turn.T)[model.deep :], abs=1e-9)


def test_sheared_hair_points_where_it_leads(particles):
    """x moves by half of how far down a particle is: so do directions, which are unit vectors."""
    model, shear = build_model(particles), np.array([[1.0, -0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    directions = particles.directions
    for _ in range(20):
        directions = turned(model, particles.points @ shear.T, directions)
    assert directions[model.deep :].mean(axis=0) == pytest.approx(np.array([0.5, -1.0, 0.0]) / np.sqrt(1.25), abs=0.06)


def test_hair_that_no_link_holds_keeps_its_direction(particles):
    model = build_model(particles)
    loose = model._replace(links=model.links._replace(strength=np.zeros_like(model.links.strength)))
    assert np.array_equal(turned(loose, particles.points, particles.directions), particles.directions)
