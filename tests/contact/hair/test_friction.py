"""Friction between hairs against Coulomb's law: sliding, sticking, joints, and what a contact remembers."""

import numpy as np
import pytest

from hairpipe.contact.contact_points import find_contacts
from hairpipe.contact.repulsion import anchor, no_shear, sheared
from hairpipe.graphs.experiments.studies.contact.rub import Rub, creep, sliding_ratio
from hairpipe.laws.settings import Collisions, StepControl, Thickness
from hairpipe.values.hair import Shear

LAW = Collisions(Thickness(3e-4), friction=0.3, stiffness=0.5)


@pytest.mark.kernels
@pytest.mark.slow
@pytest.mark.parametrize(("friction", "speed", "rate"), [(0.1, 0.005, 240), (0.3, 0.02, 96)])
def test_hair_slides_along_hair_by_coulombs_law(friction, speed, rate):
    """Its cantilever lags by friction times deflection, over several joints of the other hair."""
    rub = Rub(Collisions(friction=friction), steps=StepControl(1 / rate))
    assert sliding_ratio(rub, speed) == pytest.approx(friction, rel=0.05)


@pytest.mark.kernels
@pytest.mark.slow
def test_hair_held_below_the_limit_of_friction_does_not_creep():
    assert creep(Rub(Collisions()), 0.9, 0.3) < 1e-6


def found(cross, depth=1e-5):
    points, pairs = cross(LAW.thickness.value - depth)
    return points, find_contacts(pairs, points, np.zeros_like(points), LAW)


def test_elongation_is_the_way_along_a_contact(cross):
    """What goes apart or together along the normal elongates nothing."""
    points, contacts = found(cross)
    anchors = anchor(contacts, points, no_shear(), LAW)
    way = np.array([3e-6, -2e-6, 1e-6])
    moved = points + np.outer([1, 1, 0, 0], way)
    shear = sheared(contacts, moved, anchors)
    np.testing.assert_allclose(shear.elongations, [[3e-6, 0.0, 1e-6]], atol=1e-18)


def test_elongation_is_kept_up_to_the_limit_of_friction(cross):
    points, contacts = found(cross)
    limit = LAW.friction * contacts.loads[0] / LAW.stiffness
    apart = anchor(contacts, points, no_shear(), LAW)
    for way, kept in ((0.5 * limit, 0.5 * limit), (7.0 * limit, limit)):
        known = Shear(contacts.segments, np.array([[way, 0.0, 0.0]]))
        np.testing.assert_allclose(anchor(contacts, points, known, LAW) - apart, [[kept, 0.0, 0.0]], atol=1e-18)


@pytest.mark.parametrize(("step", "taken"), [((0, 1), True), ((-1, 1), True), ((0, 2), False)])
def test_a_contact_that_slides_over_a_joint_keeps_its_elongation(cross, step, taken):
    points, contacts = found(cross)
    apart = anchor(contacts, points, no_shear(), LAW)
    known = Shear((contacts.segments + step).astype(np.int32), np.array([[1e-6, 0.0, 0.0]]))
    change = anchor(contacts, points, known, LAW) - apart
    np.testing.assert_allclose(change, [[1e-6 * taken, 0.0, 0.0]], atol=1e-18)


def test_contacts_that_open_and_lost_hair_are_forgotten(cross):
    points, contacts = found(cross)
    anchors = anchor(contacts, points, no_shear(), LAW)
    for apart in (2e-5, np.nan):
        assert not len(sheared(contacts, points + np.outer([1, 1, 0, 0], [0.0, apart, 0.0]), anchors).segments)


def test_shear_of_some_strands_has_their_numbers():
    shear = Shear(np.array([[0, 5], [1, 7], [5, 8]], np.int32), np.eye(3))
    numbers = np.array([0, -1, -1, -1, -1, 1, 2, 3, 4])
    some = shear.renumbered(numbers)
    assert some.segments.tolist() == [[0, 1], [1, 4]]
    np.testing.assert_array_equal(some.elongations, np.eye(3)[[0, 2]])
