"""Contact springs of hair: energy, Coulomb's law, symmetry, and what a contact remembers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.contact.contact_points import USUAL, find_contacts
from hairpipe.contact.hair import union
from hairpipe.contact.repulsion import anchor, linearise, no_shear, sheared, sweep
from hairpipe.geometry.proximity import approaches, near_pairs
from hairpipe.geometry.segments import chosen
from hairpipe.graphs.experiments.studies.contact.rub import Rub, creep, sliding_ratio
from hairpipe.laws.settings import Collisions, StepControl, Thickness
from hairpipe.solve.couplings import Couplings, matrices
from hairpipe.solve.interactions import Prediction
from hairpipe.values.hair import Shear

from ..rod_scenes import cross, jacobian, pairs_within, segments_of, thrown

LAW = Collisions(Thickness(3e-4), friction=0.3, stiffness=0.5)
H = 1e-3
MASS = 4e-8


def couplings_of(pairs, points, velocities, law=LAW, h=H, at=None):
    contacts = find_contacts(pairs, points, velocities, law)
    return exerted(contacts, points if at is None else at, velocities, law, h, began=points)


def exerted(contacts, points, velocities, law=LAW, h=H, active=None, lagged_velocity=None, began=None):
    # In double precision, of which a step keeps half.
    count, pairs = len(points), len(contacts.loads)
    couplings = Couplings(contacts.segments, contacts.fractions, np.empty(pairs, np.bool_), np.zeros((pairs, 8)))
    masses, active = np.full(count, MASS), np.ones(count, np.bool_) if active is None else active
    lagged_velocity = velocities if lagged_velocity is None else lagged_velocity
    at = Prediction(points, velocities, lagged_velocity, masses, np.full(count, h), active, h, h, h)
    anchors = anchor(contacts, points if began is None else began, no_shear(), law)
    linearise(contacts, anchors, at, law, couplings)
    return couplings


@pytest.fixture
def heap():
    """Sixty rods that overlap, their pairs, and velocities."""
    points, velocities = thrown(60, 0.01, 0.008, 0.05, 3)
    return points, velocities, pairs_within(points, segments_of(60), 2 * LAW.thickness.value)


def test_force_is_minus_the_gradient_of_the_energy(heap):
    points, _, pairs = heap

    def energy(x):
        gaps = pairs_within(x, segments_of(60), LAW.thickness.value).distances
        return 0.5 * LAW.stiffness * ((LAW.thickness.value - gaps) ** 2).sum()

    couplings = couplings_of(pairs, points, np.zeros_like(points))
    force = jacobian(pairs, len(points)).T @ couplings.push.ravel() / H
    rng = np.random.default_rng(0)
    for _ in range(20):
        step = 1e-8 * rng.normal(size=points.shape)
        slope = energy(points + step) - energy(points - step)
        np.testing.assert_allclose(slope, -2 * (force @ step.ravel()), rtol=2e-3, atol=1e-16)
    assert (pairs.distances < LAW.thickness.value).sum() > 20


def test_matrix_is_that_of_the_push():
    """A push one Newton step later is what push and matrix said it would be, while nothing slides."""
    points, pairs = cross(1e-4)
    velocities = np.zeros((4, 3))
    couplings = couplings_of(pairs, points, velocities)
    change = np.array([0.0, -2e-3, 0.0])
    moved = points + H * np.outer([1, 1, 0, 0], change)
    contacts = find_contacts(pairs, points, velocities, LAW)
    faster = np.outer([1, 1, 0, 0], change)
    after = exerted(contacts, moved, faster)
    np.testing.assert_allclose(after.push, couplings.push - change @ matrices(couplings), rtol=1e-9, atol=1e-20)


def test_nothing_acts_beyond_the_thickness_and_nothing_pulls(heap):
    points, velocities, pairs = heap
    couplings = couplings_of(pairs, points, 30 * velocities)
    contacts = find_contacts(pairs, points, velocities, LAW)
    acting = couplings.acts
    assert (~acting[pairs.distances >= LAW.thickness.value]).all() and acting.sum() > 5
    assert not couplings.push[~acting].any()
    assert ((couplings.push * contacts.normals).sum(1)[acting] > 0).all()


def test_matrices_are_positive(heap):
    points, velocities, pairs = heap
    lowest = np.linalg.eigvalsh(matrices(couplings_of(pairs, points, velocities)))[:, 0]
    assert (lowest >= -1e-20).all()


def test_hair_carried_through_is_pushed_back():
    points, pairs = cross(2e-4)
    through = points - np.outer([1, 1, 0, 0], [0.0, 5e-4, 0.0])
    push = couplings_of(pairs, points, np.zeros((4, 3)), at=through).push
    assert push[0, 1] == pytest.approx(H * LAW.stiffness * 6e-4)


def test_approaching_segments_are_repelled_at_rest():
    """Rods that do not touch yet, and would go 2e-4 m into each other."""
    points, pairs = cross(4e-4)
    velocities = np.outer([1, 1, 0, 0], [0.0, -0.3, 0.0])
    contacts = find_contacts(pairs, points, velocities, LAW)
    there = exerted(contacts, points + H * velocities, velocities)
    rest = exerted(contacts, points, 0 * velocities, lagged_velocity=velocities)
    assert there.acts.all() and rest.acts.all()
    gained = there.push - rest.push + matrices(rest)[0] @ [0.0, -0.3, 0.0]
    np.testing.assert_allclose(gained, 0.0, atol=1e-9 * np.abs(there.push).max())


@pytest.mark.parametrize("speed", [1e-3, 0.01, 1.0])
@pytest.mark.parametrize("share", [0.0, 1.0])
def test_an_impact_slides_by_coulombs_law_or_stops(speed, share):
    """Rod on rod, pressed together by its overlap; one solve, linearised at rest and at the speed that it has."""
    points, pairs = cross(2.9e-4)
    velocities = np.outer([1, 1, 0, 0], [speed, 0.0, 0.0])
    guess = share * velocities
    contacts = find_contacts(pairs, points, velocities, LAW)
    contacts = contacts._replace(loads=np.zeros(1))
    couplings = exerted(contacts, points + H * guess, guess, lagged_velocity=velocities, began=points)
    J = jacobian(pairs, 4)
    A = np.kron(np.eye(4), MASS * np.eye(3)) + J.T @ matrices(couplings)[0] @ J
    dv = np.linalg.solve(A, MASS * (velocities - guess).ravel() + J.T @ couplings.push[0])
    impulse = couplings.push[0] - matrices(couplings)[0] @ (J @ dv)
    after = (J @ (guess.ravel() + dv))[0]
    limit = LAW.friction * impulse[1]
    if limit / MASS < speed:
        assert -impulse[0] == pytest.approx(limit, rel=1e-6)
    else:
        assert 0 <= after < 0.3 * speed
    assert -impulse[0] <= limit * (1 + 1e-9) and 0 <= after <= speed


def test_contacts_of_shares_exert_these_shares(heap):
    """Of the push, of its matrix, of the load, and of friction, whose elongation is the same."""
    points, velocities, pairs = heap
    pairs = chosen(pairs, ((pairs.fractions > 0.0) & (pairs.fractions < 1.0)).all(axis=1))  # Normal to both.
    shares = np.random.default_rng(4).uniform(0.1, 1.0, len(pairs.segments))
    whole, parts = (find_contacts(pairs, points, velocities, LAW, None, USUAL, each) for each in (None, shares))
    np.testing.assert_allclose(parts.loads, shares * whole.loads, rtol=1e-6)
    known = Shear(pairs.segments, np.full((len(shares), 3), 1e-4))
    kept = [anchor(contacts, points, known, LAW) for contacts in (whole, parts)]
    np.testing.assert_allclose(kept[1], kept[0], rtol=1e-6, atol=1e-12)
    soft = replace(LAW, friction=0.0)
    one, part = (exerted(contacts, points, velocities, soft) for contacts in (whole, parts))
    assert one.acts.any()
    np.testing.assert_allclose(part.push, shares[:, None] * one.push, rtol=1e-6, atol=1e-15)
    np.testing.assert_allclose(matrices(part), shares[:, None, None] * matrices(one), rtol=1e-6, atol=1e-12)


def pushed(points):
    """Force [N] on a strand of seven points by one of two points [m], (9, 3), which are at rest."""
    pairs = near_pairs(points, np.array([0, 7, 9], np.int32), 2.0 * LAW.thickness.value)
    pairs, shares = approaches(pairs, np.ones(len(pairs.distances), bool), points)
    contacts = find_contacts(pairs, points, 0.0 * points, LAW, None, USUAL, shares)
    return -exerted(contacts, points, 0.0 * points).push.sum(axis=0) / H


@pytest.mark.parametrize("angle", [60.0, 75.0, 90.0])
def test_hair_that_slides_over_a_joint_is_pushed_with_the_same_force_across_both(angle):
    """Both segments at the joint push it: along the normal of the two hairs, not away from the joint."""
    below, depth = np.linspace(-0.03, 0.03, 7)[:, None] * [1.0, 0.0, 0.0], 3e-5
    way = np.array([np.cos(np.radians(angle)), 0.0, np.sin(np.radians(angle))])
    for shift in np.linspace(-1e-4, 1e-4, 41):
        above = np.array([[-0.005], [0.005]]) * way + [shift, LAW.thickness.value - depth, 0.0]
        points = np.concatenate([below, above])
        force = pushed(points)
        np.testing.assert_allclose(force, [0.0, LAW.stiffness * depth, 0.0], atol=1e-9 * LAW.stiffness * depth)


@pytest.mark.parametrize("shift", [0.0, 1e-6, 1e-5])
def test_a_tip_that_meets_a_joint_end_on_is_pushed_back_where_it_came_from(shift):
    """Not out of the plane of the two hairs, which their common normal would."""
    below, apart = np.linspace(-0.03, 0.03, 7)[:, None] * [1.0, 0.0, 0.0], LAW.thickness.value - 3e-5
    points = np.concatenate([below, [[shift, apart + 0.01, 0.0], [shift, apart, 0.0]]])
    force = pushed(points)
    np.testing.assert_allclose(force, [0.0, 3e-5 * LAW.stiffness, 0.0], atol=0.1 * 3e-5 * LAW.stiffness)


def test_a_tip_that_turns_over_a_joint_is_pushed_without_a_jump():
    """From end on to lying across it: the normal turns from that of the two points to that of both hairs."""
    below, depth = np.linspace(-0.03, 0.03, 7)[:, None] * [1.0, 0.0, 0.0], 3e-5
    tip = np.array([0.0, LAW.thickness.value - depth, 0.0])
    forces = []
    for angle in np.radians(np.linspace(0.0, 90.0, 901)):
        points = np.concatenate([below, [tip + 0.01 * np.array([0.0, np.cos(angle), np.sin(angle)]), tip]])
        forces.append(pushed(points))
    assert np.linalg.norm(np.diff(forces, axis=0), axis=1).max() < 0.03 * LAW.stiffness * depth


def test_coincident_and_parallel_hair_is_pushed_apart_the_same_way():
    points, pairs = cross(0.0)
    velocities = np.outer([1, 1, 0, 0], [0.0, -1e-3, 0.0])
    pushes = [couplings_of(pairs, points, velocities).push for _ in range(2)]
    assert pushes[0][0, 1] > 0 and (pushes[0] == pushes[1]).all()
    same = pairs._replace(segments=np.array([[0, 2]], np.int32))
    laid = points[[0, 1, 0, 1]]
    for velocity in (velocities, np.zeros((4, 3))):
        push = couplings_of(same, laid, velocity).push[0]
        assert np.isfinite(push).all() and np.linalg.norm(push) > 0
        assert abs(push @ (laid[1] - laid[0])) < 1e-12 * np.linalg.norm(push)


def test_turned_hair_gets_turned_pushes(heap):
    points, velocities, pairs = heap
    turn = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix()
    one = couplings_of(pairs, points, velocities)
    two = couplings_of(pairs, points @ turn.T, velocities @ turn.T)
    np.testing.assert_allclose(two.push, one.push @ turn.T, atol=1e-9 * np.abs(one.push).max())
    expected = turn @ matrices(one) @ turn.T
    np.testing.assert_allclose(matrices(two), expected, atol=1e-9 * np.abs(expected).max())


def test_threads_do_not_matter(heap, same_on_threads):
    points, velocities, pairs = heap
    same_on_threads(lambda: couplings_of(pairs, points, velocities))


def test_pairs_of_inactive_strands_are_excluded(heap):
    points, velocities, pairs = heap
    contacts = find_contacts(pairs, points, velocities, LAW)
    everyone = exerted(contacts, points, velocities)
    active = np.random.default_rng(2).random(len(points)) < 0.3
    some = exerted(contacts, points, velocities, active=active)
    asked = active[pairs.segments].any(axis=1)
    assert everyone.acts[asked].any() and everyone.acts[~asked].any()
    np.testing.assert_array_equal(some.acts, everyone.acts & asked)
    for one, all_of_them in zip(some[3:], everyone[3:], strict=True):
        np.testing.assert_array_equal(one, np.where(asked[:, None], all_of_them, 0.0))


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


def found(depth=1e-5):
    points, pairs = cross(LAW.thickness.value - depth)
    return points, find_contacts(pairs, points, np.zeros_like(points), LAW)


def test_elongation_is_the_way_along_a_contact():
    """What goes apart or together along the normal elongates nothing."""
    points, contacts = found()
    anchors = anchor(contacts, points, no_shear(), LAW)
    way = np.array([3e-6, -2e-6, 1e-6])
    moved = points + np.outer([1, 1, 0, 0], way)
    shear = sheared(contacts, moved, anchors)
    np.testing.assert_allclose(shear.elongations, [[3e-6, 0.0, 1e-6]], atol=1e-18)


def test_elongation_is_kept_up_to_the_limit_of_friction():
    points, contacts = found()
    limit = LAW.friction * contacts.loads[0] / LAW.stiffness
    apart = anchor(contacts, points, no_shear(), LAW)
    for way, kept in ((0.5 * limit, 0.5 * limit), (7.0 * limit, limit)):
        known = Shear(contacts.segments, np.array([[way, 0.0, 0.0]]))
        np.testing.assert_allclose(anchor(contacts, points, known, LAW) - apart, [[kept, 0.0, 0.0]], atol=1e-18)


@pytest.mark.parametrize(("step", "taken"), [((0, 1), True), ((-1, 1), True), ((0, 2), False)])
def test_a_contact_that_slides_over_a_joint_keeps_its_elongation(step, taken):
    points, contacts = found()
    apart = anchor(contacts, points, no_shear(), LAW)
    known = Shear((contacts.segments + step).astype(np.int32), np.array([[1e-6, 0.0, 0.0]]))
    change = anchor(contacts, points, known, LAW) - apart
    np.testing.assert_allclose(change, [[1e-6 * taken, 0.0, 0.0]], atol=1e-18)


def test_contacts_that_open_and_lost_hair_are_forgotten():
    points, contacts = found()
    anchors = anchor(contacts, points, no_shear(), LAW)
    for apart in (2e-5, np.nan):
        assert not len(sheared(contacts, points + np.outer([1, 1, 0, 0], [0.0, apart, 0.0]), anchors).segments)


def test_shear_of_some_strands_has_their_numbers():
    shear = Shear(np.array([[0, 5], [1, 7], [5, 8]], np.int32), np.eye(3))
    numbers = np.array([0, -1, -1, -1, -1, 1, 2, 3, 4])
    some = shear.renumbered(numbers)
    assert some.segments.tolist() == [[0, 1], [1, 4]]
    np.testing.assert_array_equal(some.elongations, np.eye(3)[[0, 2]])


@pytest.mark.parametrize(("few", "many"), [(0, 0), (0, 5), (7, 90), (40_000, 90_000)])
def test_a_union_is_that_of_sets(few, many):
    rng = np.random.default_rng(few)
    a, b = (np.unique(rng.integers(0, 2 * many + 1, count)) for count in (few, many))
    apart = a[~np.isin(a, b)]
    for one, other in ((a, b), (b, a), (apart, b)):
        np.testing.assert_array_equal(union(one, other), np.union1d(one, other))


SWEPT = Collisions(Thickness(3e-4), friction=0.3, stiffness=0.5, sweeps=3)
DT = 1 / 240


@pytest.fixture
def held_heap():
    """A heap of rods of different masses, some held at an end, with their pairs."""
    points, velocities = thrown(80, 0.01, 0.008, 0.1, 5)
    masses = np.random.default_rng(1).uniform(1e-8, 9e-8, len(points))
    return points, velocities, masses, pairs_within(points, segments_of(80), 1.1 * SWEPT.thickness.value)


def swept(held_heap, law=SWEPT, elastic=True):
    points, velocities, masses, pairs = held_heap
    after = velocities.copy()
    sweep(pairs, points, after, masses, law, DT, elastic=elastic)
    return after


def test_momentum_is_kept(held_heap):
    _, velocities, masses, pairs = held_heap
    after = swept(held_heap)
    scale = (masses[:, None] * np.abs(after - velocities)).sum()
    assert np.linalg.norm(masses @ (after - velocities)) < 1e-10 * scale
    assert len(pairs.segments) > 40 and (after != velocities).any(1).sum() > 40


def test_angular_momentum_is_kept_but_for_the_lever_of_friction(held_heap):
    """Normal impulses act along the line between the two points; friction does so from one to the other of them."""
    points, velocities, masses, _ = held_heap
    after = swept(held_heap, Collisions(Thickness(3e-4), friction=0.0))
    change = masses[:, None] * (after - velocities)
    assert (
        np.linalg.norm(np.cross(points, change).sum(0)) < 1e-10 * np.linalg.norm(np.cross(points, change), axis=1).sum()
    )


def test_energy_falls(held_heap):
    _, velocities, masses, _ = held_heap
    after = swept(held_heap, elastic=False)
    assert (masses * (after**2).sum(1)).sum() < 0.999 * (masses * (velocities**2).sum(1)).sum()


def test_held_points_keep_their_velocity(held_heap):
    points, velocities, masses, pairs = held_heap
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
    assert -change[0] == pytest.approx(min(SWEPT.friction * change[1], sideways))


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


def test_turned_hair_gets_turned_impulses(held_heap):
    points, velocities, masses, pairs = held_heap
    turn = Rotation.from_rotvec([1.3, -1.0, 0.5]).as_matrix()
    turned = swept((points @ turn.T, velocities @ turn.T, masses, pairs))
    np.testing.assert_allclose(turned, swept(held_heap) @ turn.T, atol=1e-10)
