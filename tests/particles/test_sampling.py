"""Particles stand evenly for the hair of a groom."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.particles.sampling import darts, sample
from hairpipe.values.strand_arrays import take

from .conftest import groom_of


@pytest.mark.parametrize("sampling", ["strands", "even"])
def test_there_are_as_many_as_requested_and_some_below_the_skin_come_first(curtain, sampling):
    samples = sample(curtain, 500, sampling, 3)
    arcs = samples.places.arcs
    deep = int(np.count_nonzero(arcs < 0.0))
    assert len(arcs) - deep == pytest.approx(500, rel=0.03) and (arcs[deep:] >= 0.0).all()
    roots = samples.hair.points[samples.hair.offsets[:-1]][samples.places.strands]
    assert samples.points == pytest.approx(roots + arcs[:, None] * (0.0, -1.0, 0.0), abs=1e-12)
    assert samples.directions == pytest.approx(np.tile([0.0, -1.0, 0.0], (len(arcs), 1)))
    assert samples.length == pytest.approx(0.2 * len(curtain.ids))


def test_even_ones_are_as_far_apart_as_each_other(curtain):
    samples = sample(curtain, 500, "even", 0)
    nearest = KDTree(samples.points).query(samples.points, k=2)[0][:, 1]
    assert nearest.std() / nearest.mean() <= 0.06


def test_on_strands_they_are_a_spacing_apart_along_the_hair(curtain):
    places = sample(curtain, 500, "strands", 0).places
    order = np.lexsort((places.arcs, places.strands))
    steps, same = np.diff(places.arcs[order]), np.diff(places.strands[order]) == 0
    assert np.ptp(steps[same]) < 1e-12 and places.arcs.min() > -2.5 * steps[same][0]


def test_another_seed_gives_others_and_the_same_the_same(curtain):
    first, again, other = (sample(curtain, 300, "strands", seed).points for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert len(first) != len(other) or not np.array_equal(first, other)


def test_no_two_darts_are_nearer_than_the_spacing_and_there_is_no_room_for_more():
    points = np.random.default_rng(0).uniform(size=(400, 3))
    taken = darts(KDTree(points), np.arange(400), 0.2)
    apart = np.linalg.norm(points[taken][:, None] - points[taken], axis=2)[np.triu_indices(len(taken), 1)]
    assert apart.min() > 0.2
    assert KDTree(points[taken]).query(points)[0].max() <= 0.2


@pytest.mark.parametrize("lean", [-20.0, 0.0, 30.0, 45.0, 70.0])
def test_below_the_skin_they_go_in_at_45_degrees_or_steeper(lean):
    """Hair that leaves skin that faces down, at an angle from along it; less than none is into the head."""
    way = np.array([np.cos(np.radians(lean)), -np.sin(np.radians(lean)), 0.0])
    roots = np.random.default_rng(2).uniform(-0.05, 0.05, (60, 3)) * (1.0, 0.0, 1.0)
    samples = sample(groom_of([root + np.linspace(0.0, 0.2, 21)[:, None] * way for root in roots]), 300, "strands", 0)
    deep = samples.places.arcs < 0.0
    steep = np.radians(max(lean, 45.0))
    assert samples.directions[deep] == pytest.approx(
        np.tile([np.cos(steep), -np.sin(steep), 0.0], (np.count_nonzero(deep), 1)), abs=1e-12
    )
    assert samples.points[deep, 1] == pytest.approx(-samples.places.arcs[deep] * np.sin(steep))


def test_those_of_a_curl_lie_on_its_axis_and_point_along_it():
    curl = wound(Helix(0.01, 0.02), 0.5, 120) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    roots = np.random.default_rng(2).uniform(-0.05, 0.05, (60, 3)) * (1.0, 0.0, 1.0)
    samples = sample(groom_of([root + curl for root in roots]), 300, "strands", 0)
    axis = samples.hair.points[samples.hair.offsets[:-1]][samples.places.strands] - (0.01, 0.0, 0.0)
    assert np.abs((samples.points - axis)[:, [0, 2]]).max() < 1e-3
    assert np.abs(samples.directions[:, 1]).min() > 0.99


def test_too_many_particles_and_no_hair_are_refused(curtain):
    few = take(curtain, np.arange(5))
    with pytest.raises(BadInput, match="particles: 500 particles on a groom of 205 points"):
        sample(few, 500, "strands", 0)
    none = replace(take(curtain, np.arange(1)), ids=np.empty(0, np.int32))
    with pytest.raises(BadInput, match="no hair grows from the scalp"):
        sample(none, 100, "even", 0)
