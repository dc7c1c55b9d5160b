"""Impulses pair by pair: laws of mechanics, and what one pair ends with."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.contact.repulsion import sweep
from hairpipe.laws.settings import Collisions, Thickness

from ..rod_scenes import cross, pairs_within, segments_of, thrown

LAW = Collisions(Thickness(3e-4), friction=0.3, stiffness=0.5, sweeps=3)
DT = 1 / 240


@pytest.fixture
def heap():
    """A heap of rods of different masses, some held at an end, with their pairs."""
    points, velocities = thrown(80, 0.01, 0.008, 0.1, 5)
    masses = np.random.default_rng(1).uniform(1e-8, 9e-8, len(points))
    return points, velocities, masses, pairs_within(points, segments_of(80), 1.1 * LAW.thickness.value)


def swept(heap, law=LAW, elastic=True):
    points, velocities, masses, pairs = heap
    after = velocities.copy()
    sweep(pairs, points, after, masses, law, DT, elastic=elastic)
    return after


def test_momentum_is_kept(heap):
    _, velocities, masses, pairs = heap
    after = swept(heap)
    scale = (masses[:, None] * np.abs(after - velocities)).sum()
    assert np.linalg.norm(masses @ (after - velocities)) < 1e-10 * scale
    assert len(pairs.segments) > 40 and (after != velocities).any(1).sum() > 40


def test_angular_momentum_is_kept_but_for_the_lever_of_friction(heap):
    """Normal impulses act along the line between the two points; friction does so from one to the other of them."""
    points, velocities, masses, _ = heap
    after = swept(heap, Collisions(Thickness(3e-4), friction=0.0))
    change = masses[:, None] * (after - velocities)
    assert (
        np.linalg.norm(np.cross(points, change).sum(0)) < 1e-10 * np.linalg.norm(np.cross(points, change), axis=1).sum()
    )


def test_energy_falls(heap):
    _, velocities, masses, _ = heap
    after = swept(heap, elastic=False)
    assert (masses * (after**2).sum(1)).sum() < 0.999 * (masses * (velocities**2).sum(1)).sum()


def test_held_points_keep_their_velocity(heap):
    points, velocities, masses, pairs = heap
    held = np.arange(0, len(points), 3)
    masses = masses.copy()
    masses[held] = np.inf
    after = swept((points, velocities, masses, pairs))
    assert (after[held] == velocities[held]).all() and (after != velocities).any()


@pytest.mark.parametrize("sideways", [0.01, 1.0])
def test_a_pair_stops_and_its_friction_is_within_the_cone(sideways):
    points, pairs = cross(2e-4)
    velocities = np.outer([1, 1, 0, 0], [sideways, -0.5, 0.0])
    after = swept((points, velocities, np.full(4, 4e-8), pairs), elastic=False)
    u = (after[0] + after[1] - after[2] - after[3]) / 2
    change = u - [sideways, -0.5, 0.0]
    assert u[1] == pytest.approx(0.0, abs=1e-15)  # restitution 0
    assert -change[0] == pytest.approx(min(LAW.friction * change[1], sideways))


def test_the_spring_undoes_a_tenth_of_the_overlap_or_what_it_can():
    points, pairs = cross(2e-4)
    still = np.zeros((4, 3))
    for stiffness in (1e-4, 10.0):
        law = Collisions(Thickness(3e-4), stiffness=stiffness)
        after = swept((points, still, np.full(4, 4e-8), pairs), law)
        apart = (after[0] + after[1] - after[2] - after[3])[1] / 2
        assert apart == pytest.approx(min(0.1e-4 / DT, DT * stiffness * 1e-4 / 4e-8))


def test_hair_within_reach_slows_down_before_it_touches():
    points, pairs = cross(3.2e-4)
    velocities = np.outer([1, 1, 0, 0], [0.0, -0.5, 0.0])
    after = swept((points, velocities, np.full(4, 4e-8), pairs))
    assert (after[0] - after[2])[1] == pytest.approx(-0.1 * 2e-5 / DT)


def test_ends_are_omitted():
    points, pairs = cross(2e-4)
    velocities = np.outer([1, 1, 0, 0], [0.0, -0.5, 0.0])
    at_end = pairs._replace(fractions=np.array([[0.5, 1.0]]))
    assert (swept((points, velocities, np.full(4, 4e-8), at_end)) == velocities).all()


def test_turned_hair_gets_turned_impulses(heap):
    points, velocities, masses, pairs = heap
    turn = Rotation.from_rotvec([1.3, -1.0, 0.5]).as_matrix()
    turned = swept((points @ turn.T, velocities @ turn.T, masses, pairs))
    np.testing.assert_allclose(turned, swept(heap) @ turn.T, atol=1e-10)
