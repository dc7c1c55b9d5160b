"""Stiction: springs with an energy, that conserve, let go at once, and cost hair that parts no more than their work."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hairpipe.contact.collision import collide
from hairpipe.contact.hair import HairContacts
from hairpipe.contact.repulsion import sweep
from hairpipe.contact.stiction import (
    Connections,
    connect,
    linearise,
    no_connections,
    release,
    room,
    same_hair_keys,
    stiffest,
)
from hairpipe.geometry.proximity import closest_pairs, near_pairs
from hairpipe.geometry.segments import ages_of, key_of
from hairpipe.laws.adhesion import adhesion
from hairpipe.laws.settings import Collisions, Force, Stiction, Thickness
from hairpipe.shot.build import surroundings_of
from hairpipe.shot.simulate import start
from hairpipe.solve.couplings import Couplings, coupling_rows, find_incidence, matrices
from hairpipe.solve.integrators import G
from hairpipe.solve.interactions import Prediction, Start
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

from ...laws.checks import check_balance, check_law
from ..coupled_strands import whole_matrix

STICTION = Stiction()
SLACK = STICTION.release - STICTION.reach
STIFFNESS = STICTION.force.value / SLACK


def parallel_strands(gap, count=2, points=4):
    """Straight strands along -y, a gap apart along x."""
    grid = np.zeros((count, points, 3))
    grid[:, :, 0] = gap * np.arange(count)[:, None]
    grid[:, :, 1] = -3e-3 * np.arange(points)
    return grid.reshape(-1, 3), np.arange(0, (count + 1) * points, points, dtype=np.int32)


def web(seed=0, count=300, longest=STICTION.release):
    """Random hair with connections of random lengths, some shorter than reach and none released."""
    rng = np.random.default_rng(seed)
    offsets = np.array([0, 40, 80], np.int32)
    x = 4e-4 * rng.normal(size=(80, 3)).cumsum(axis=0)
    first = rng.integers(0, 39, count)
    pairs = np.unique(np.stack([first, 40 + rng.integers(0, 39, count)], 1), axis=0).astype(np.int32)
    connections = Connections(pairs, rng.random(pairs.shape))
    x[40:] += np.median(x[:40], axis=0) - np.median(x[40:], axis=0)
    kept = release(connections, x, longest, np.ones(len(x)))
    assert len(kept.segments) > 20
    return SimpleNamespace(
        x=x, v=rng.normal(size=x.shape), masses=rng.uniform(1e-8, 4e-8, 80), connections=kept, offsets=offsets
    )


def gaps(connections, x):
    s = connections.fractions[:, :, None]
    ends = (1 - s) * x[connections.segments] + s * x[connections.segments + 1]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def energy(connections, x):
    return 0.5 * STIFFNESS * ((gaps(connections, x) - STICTION.reach) ** 2).sum()


def exerted(connections, x, v, masses, stiction, h, active=None, began=None):
    # In double precision, of which a step keeps half.
    count, single = len(connections.segments), np.ones(len(x))
    couplings = Couplings(*connections, np.empty(count, np.bool_), np.zeros((count, 8)))
    active = np.ones(len(x), np.bool_) if active is None else active
    at = Prediction(x, v, v, masses, np.full(len(x), h), active, h, h, h)
    first = Start(x if began is None else began, v, masses, 0.0, 0.0, h)
    linearise(connections, first, at, stiction, couplings, single, single)
    return couplings


def forces(web, x, v=0.0, h=1.0, stiction=STICTION):
    """Force on every point [N]."""
    couplings = exerted(web.connections, x, np.broadcast_to(v, x.shape) + 0.0, web.masses, stiction, h)
    return coupling_rows(couplings, find_incidence(couplings.segments, len(x))).push / h


def test_it_keeps_the_laws_of_its_energy():
    case = web()
    check_law(lambda x: energy(case.connections, x), lambda x: forces(case, x), None, case.x, steps=(1e-8, 0.0))
    check_balance(case.x, forces(case, case.x, case.v))


def test_the_matrix_is_the_slope_of_the_force_where_it_pulls_and_never_negative():
    case = web()
    plain = Stiction(damping=0.0)
    M = matrices(exerted(case.connections, case.x, 0 * case.x, case.masses, plain, 1.0))
    pulls = gaps(case.connections, case.x) > STICTION.reach
    assert 5 < pulls.sum() < len(pulls)
    assert np.linalg.eigvalsh(M).min() > -1e-12 * STIFFNESS
    for i in np.flatnonzero(pulls)[:20]:
        a = case.connections.segments[i, 0]
        one = Connections(case.connections.segments[i : i + 1], case.connections.fractions[i : i + 1])
        for c in range(3):
            pushes = []
            for side in (1, -1):
                moved = case.x.copy()
                moved[[a, a + 1], c] += side * 1e-9
                pushes.append(exerted(one, moved, 0 * moved, case.masses, plain, 1.0).push[0])
            np.testing.assert_allclose(M[i, c], -(pushes[0] - pushes[1]) / 2e-9, atol=1e-5 * STIFFNESS)


def test_a_push_keeps_its_direction_in_a_step_and_a_pull_turns_with_its_points():
    one, masses, h = Connections(np.array([[1, 5]], np.int32), np.full((1, 2), 0.5)), np.full(8, 1e-8), 1e-3
    for gap in (0.8 * STICTION.reach, 0.5 * (STICTION.reach + STICTION.release)):
        began, _ = parallel_strands(gap)
        turned = began.copy()
        turned[4:] = began[:4] + gap * np.array([0.8, 0.0, 0.6])
        way = began[4] - began[0] if gap < STICTION.reach else turned[4] - turned[0]
        push = exerted(one, turned, 0 * turned, masses, STICTION, h, began=began).push[0]
        np.testing.assert_allclose(push, h * STIFFNESS * (gap - STICTION.reach) * way / gap, rtol=1e-9)


def test_only_parting_is_damped_and_by_the_fraction_of_critical():
    case = web()
    couplings = exerted(case.connections, case.x, case.v, case.masses, STICTION, 1.0)
    still = exerted(case.connections, case.x, 0 * case.v, case.masses, STICTION, 1.0)
    for i, ((a, b), (s, t)) in enumerate(zip(*case.connections, strict=True)):
        weights, places = np.array([1 - s, s, t - 1, -t]), [a, a + 1, b, b + 1]
        d = weights @ case.x[places]
        d /= np.linalg.norm(d)
        mass = 1 / (weights**2 / case.masses[places]).sum()
        c = 2 * STICTION.damping * np.sqrt(STIFFNESS * mass)
        expected = -c * (weights @ case.v[places] @ d) * d
        np.testing.assert_allclose(couplings.push[i] - still.push[i], expected, atol=1e-9 * np.abs(expected).max())


def test_force_ends_at_the_release_distance():
    connections, pulls = Connections(np.array([[1, 5]], np.int32), np.full((1, 2), 0.5)), []
    extensions = np.linspace(0.1e-3, 2.5e-3, 49)
    for gap in extensions:
        x, _ = parallel_strands(gap)
        connections = release(connections, x, STICTION.release, np.ones(len(x)))
        pushes = exerted(connections, x, 0 * x, np.full(8, 1e-8), STICTION, 1.0).push
        pulls.append(pushes[0, 0] if len(pushes) else 0.0)
    held = extensions < STICTION.release + 1e-9
    np.testing.assert_allclose(np.array(pulls)[held], STIFFNESS * (extensions[held] - STICTION.reach), rtol=1e-9)
    np.testing.assert_allclose(pulls[np.flatnonzero(held)[-1]], STICTION.force.value)
    assert not np.array(pulls)[~held].any()


def part(speed, mass, dt):
    """Speed at which two free points part that began connected, at rest length, and at a speed; by TR-BDF2."""
    x, _ = parallel_strands(STICTION.reach)
    masses = np.full(8, mass)  # connected in the middle of their segments: 1/m = 4 (1/2)^2 / mass
    connections = Connections(np.array([[1, 5]], np.int32), np.full((1, 2), 0.5))
    h, w1 = G * dt / 2, 1 / (G * (2 - G))
    gap, v, a = STICTION.reach, speed, 0.0

    def solve(gap_h, v_h, guess):
        x[4:, 0] = gap_h + h * guess
        velocities = np.zeros_like(x)
        velocities[4:, 0] = guess
        couplings = exerted(connections, x, velocities, masses, STICTION, h)
        v = guess + (mass * (v_h - guess) - couplings.push[0, 0]) / (mass + matrices(couplings)[0, 0, 0])
        return gap_h + h * v, v, (v - v_h) / h

    while gap <= STICTION.release and v > 1e-3 * speed:
        gap1, v1, _ = solve(gap + h * v, v + h * a, v)
        gap, v, a = solve(w1 * gap1 + (1 - w1) * gap, w1 * v1 + (1 - w1) * v, v1)
    return max(v, 0.0)


@pytest.mark.parametrize("speed", [0.2, 1.0, 1.5, 3.0, 10.0])
@pytest.mark.parametrize("dt", [1 / 240, 1 / 1000])
def test_hair_parts_at_the_speed_it_has_left_for_any_step(speed, dt):
    """A step that ends far beyond release must not take what stiction never could, nor turn hair round."""
    assert part(speed, 1e-7, dt) == pytest.approx(part(speed, 1e-7, 5e-6), abs=0.17)


def test_points_in_one_place_are_pushed_apart_in_one_direction():
    x, _ = parallel_strands(0.0)
    connections = Connections(np.array([[0, 4], [1, 5]], np.int32), np.full((2, 2), 0.5))
    first, second = (exerted(connections, x, 0 * x, np.full(8, 1e-8), STICTION, 1.0) for _ in range(2))
    assert np.array_equal(first.push, second.push)
    np.testing.assert_allclose(np.linalg.norm(first.push, axis=1), STIFFNESS * STICTION.reach)
    assert np.isfinite(matrices(first)).all()


def test_no_segment_gets_more_connections_than_the_cap_and_none_moves():
    rng = np.random.default_rng(5)
    x, offsets = parallel_strands(1.2e-4, count=12, points=6)
    connections = no_connections()
    for step in range(6):
        x += 1e-4 * rng.normal(size=x.shape)
        before = release(connections, x, 4e-4, np.ones(len(x)))
        free = room(before, len(x), 3)
        pairs = near_pairs(x, offsets, 3e-4, key_of(before.segments))
        near = closest_pairs(x, pairs, np.ones(len(pairs.distances), bool), 3, free)
        connections = connect(before, near)
        keys = key_of(connections.segments)
        assert np.all(np.diff(keys) > 0)
        assert np.bincount(connections.segments.ravel()).max() == 3
        kept = np.isin(keys, key_of(before.segments))
        assert step == 0 or 0 < kept.sum() < len(keys)
        np.testing.assert_array_equal(connections.fractions[kept], before.fractions)
        np.testing.assert_array_equal(connections.fractions[~kept], near.fractions)


def test_a_curl_connects_to_itself_only_between_segments_distant_at_rest():
    angle = np.linspace(0, 6 * np.pi, 60)
    curl = np.stack([2e-3 * np.cos(angle), -4e-4 * angle / (2 * np.pi), 2e-3 * np.sin(angle)], axis=1)
    x, offsets = np.concatenate([curl, curl + np.array([3e-4, 0, 0])]), np.array([0, 60, 120], np.int32)
    keys = same_hair_keys(x, offsets, 5e-4)
    assert len(keys) and np.all(np.diff(keys) > 0)
    one = near_pairs(curl, np.array([0, 60], np.int32), 5e-4).segments
    np.testing.assert_array_equal(keys, np.concatenate([key_of(one), key_of(one + 60)]))
    squeezed = x * [1, 0.3, 1]
    pairs = near_pairs(squeezed, offsets, 5e-4, keys)
    made = closest_pairs(squeezed, pairs, np.ones(len(pairs.distances), bool), 16).segments
    assert not np.isin(key_of(made), keys).any()
    same = made // 60
    assert (same[:, 0] == same[:, 1]).any() and (same[:, 0] != same[:, 1]).any()


def test_hair_that_is_not_finite_is_let_go_and_exerts_nothing():
    case = web()
    x, v = case.x.copy(), case.v.copy()
    lost = case.connections.segments[4, 0]
    x[lost] = np.nan
    v[case.connections.segments[9, 1]] = np.inf
    couplings = exerted(case.connections, x, v, case.masses, STICTION, 1e-3)
    assert np.isfinite(couplings.push).all() and np.isfinite(matrices(couplings)).all()
    assert couplings.push.any()
    touched = np.isin(case.connections.segments, [lost - 1, lost]).any(axis=1)
    left = release(case.connections, x, STICTION.release, np.ones(len(x))).segments
    np.testing.assert_array_equal(left, case.connections.segments[~touched])


def test_the_bound_on_the_frequency_holds():
    case = web()
    couplings = exerted(case.connections, case.x, 0 * case.x, case.masses, Stiction(damping=0.0), 1.0)
    K = whole_matrix(couplings, 80) / np.sqrt(np.outer(*[np.repeat(case.masses, 3)] * 2))
    highest = np.linalg.eigvalsh(K).max()
    assert highest <= stiffest(case.connections, case.masses, STICTION, np.ones(80)) < 20 * highest
    assert stiffest(no_connections(), case.masses, STICTION, np.ones(80)) == 0.0


def test_pairs_of_inactive_strands_are_excluded():
    case = web()
    everyone = exerted(case.connections, case.x, case.v, case.masses, STICTION, 1e-3)
    active = np.arange(len(case.x)) < 20
    some = exerted(case.connections, case.x, case.v, case.masses, STICTION, 1e-3, active)
    asked = active[case.connections.segments].any(axis=1)
    assert everyone.acts[asked].all() and everyone.acts[~asked].all()
    np.testing.assert_array_equal(some.acts, asked)
    np.testing.assert_array_equal(some.exerted[asked], everyone.exerted[asked])


def test_a_connection_that_stayed_where_it_was_has_lasted_a_frame_longer():
    before, places = np.array([[0, 5], [1, 6], [2, 7]], np.int32), np.full((3, 2), 0.5)
    now, here = np.concatenate([before, [[20, 25]]]).astype(np.int32), np.full((4, 2), 0.5)
    here[1, 0] = 0.25  # broke, and was made again elsewhere
    np.testing.assert_array_equal(ages_of(before, places, np.array([4, 7, 0]), now, here), [5, 0, 1, 0])


@pytest.mark.parametrize("times", [1.0, 1.5, 4.0, 100.0])
def test_a_connection_that_breaks_in_a_step_does_the_work_of_release(times):

    k, _ = adhesion(STIFFNESS, 0.5, times * SLACK, SLACK, 1e6)
    assert 0.5 * k * (times * SLACK) ** 2 == pytest.approx(0.5 * STIFFNESS * SLACK**2)


def test_the_damping_of_a_connection_is_none_for_held_points():
    assert adhesion(STIFFNESS, 0.5, 0.5 * STICTION.reach, SLACK, 0.0)[1] == 0.0


FORCE = 2e-5
UNDAMPED = Stiction(force=Force(FORCE), damping=0.0)


def pulls(x, connections, grips):
    """Force on every point at rest [N]."""
    count = len(connections.segments)
    couplings = Couplings(*connections, np.empty(count, np.bool_), np.zeros((count, 8)))
    masses, ones = np.full(len(x), 1e-8), np.ones(len(x))
    at = Prediction(x, 0 * x, 0 * x, masses, ones, ones > 0, 1.0, 1.0, 1.0)
    linearise(connections, Start(x, 0 * x, masses, 0.0, 0.0, 1.0), at, UNDAMPED, couplings, ones, grips)
    return coupling_rows(couplings, find_incidence(connections.segments, len(x))).push


@pytest.mark.parametrize(("first", "second"), [(1.0, 0.25), (0.5, 0.5), (1.0, 0.0)])
def test_two_segments_pull_with_the_geometric_mean_of_their_forces(first, second):
    gap = 0.5 * (UNDAMPED.reach + UNDAMPED.release)
    x = np.array([[0.0, 0, 0], [0, 0.01, 0], [gap, 0, 0], [gap, 0.01, 0]])
    grips = np.sqrt([first, 1.0, second, 1.0])
    found = pulls(x, Connections(np.array([[0, 2]], np.int32), np.array([[0.5, 0.5]])), grips)
    half = 0.5 * FORCE * np.sqrt(first * second)  # at half of the way from reach to release
    np.testing.assert_allclose(found[:, 0], 0.5 * half * np.array([1.0, 1.0, -1.0, -1.0]), rtol=1e-12)


def random_web():
    rng = np.random.default_rng(3)
    pairs = np.unique(np.stack([rng.integers(0, 19, 40), 20 + rng.integers(0, 19, 40)], 1), axis=0).astype(np.int32)
    x = np.concatenate([4e-4 * rng.normal(size=(20, 3)).cumsum(axis=0) for _ in range(2)])
    return x, Connections(pairs, rng.random(pairs.shape)), rng.uniform(0.1, 1.0, len(x))


def test_force_of_unequal_segments_is_the_slope_of_their_energy():
    x, connections, grips = random_web()
    x[20:] += 2e-4
    stiffness = FORCE / (UNDAMPED.release - UNDAMPED.reach) * grips[connections.segments].prod(axis=1)

    def energy(points):
        s = connections.fractions[:, :, None]
        ends = (1 - s) * points[connections.segments] + s * points[connections.segments + 1]
        longer = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) - UNDAMPED.reach
        slack = UNDAMPED.release - UNDAMPED.reach
        beyond = slack**2 * (0.5 + np.log(np.maximum(longer, slack) / slack))  # breaks with a force k slack^2 / longer
        return np.where(longer < slack, 0.5 * longer**2, beyond) @ stiffness

    check_law(energy, lambda points: pulls(points, connections, grips), None, x, steps=(1e-8, 0.0))


def test_the_bound_of_the_frequency_has_the_factors_of_pairs():
    _, connections, _ = random_web()
    masses = np.full(40, 1e-8)
    whole = stiffest(connections, masses, UNDAMPED, np.ones(40))
    assert stiffest(connections, masses, UNDAMPED, np.full(40, 0.5)) == pytest.approx(0.25 * whole)


@pytest.mark.parametrize("gap", [0.05, 4e-4])
def test_a_crossing_ends_at_the_mean_thickness(gap):
    """Of a hair of 0.6 and one of 0.2 mm: 0.4 mm."""
    before = np.array([[-0.01, gap, 0], [0.01, gap, 0], [0, 0, -0.01], [0, 0, 0.01]])
    after = before - np.outer([1, 1, 0, 0], [0.0, 0.1, 0.0])
    law, widths = Collisions(Thickness(6e-4)), np.array([1.0, 1.0, 1 / 3, 1 / 3])
    found = collide(before, after, np.full(4, 1e-8), np.array([0, 2, 4], np.int32), 0.01, law, None, widths)
    ended = after + 0.01 * found.change
    assert ended[0, 1] - ended[2, 1] == pytest.approx(4e-4)


def test_the_published_impulses_stop_at_the_mean_thickness():
    x = np.array([[-0.01, 5e-4, 0], [0.01, 5e-4, 0], [0, 0, -0.01], [0, 0, 0.01]])
    offsets, law = np.array([0, 2, 4], np.int32), Collisions(Thickness(6e-4), stiffness=1e4)
    for widths, pushed in ((None, True), (np.array([1.0, 1.0, 1 / 3, 1 / 3]), False)):
        v = np.zeros((4, 3))
        sweep(near_pairs(x, offsets, 1e-3), x, v, np.full(4, 1e-8), law, 0.01, widths, elastic=True)
        assert bool(v.any()) is pushed  # 0.5 mm apart: nearer than 0.6 mm, and not nearer than 0.4 mm


def test_pairs_are_near_within_the_mean_of_their_widths():
    x = np.array([[0.0, 0, 0], [0.01, 0, 0], [0, 1e-3, 0], [0.01, 1e-3, 0], [0, -1e-3, 0], [0.01, -1e-3, 0]])
    widths = np.repeat([1.0, 0.5, 0.1], 2)
    found = near_pairs(x, np.arange(0, 7, 2, dtype=np.int32), 1.5e-3, None, widths)
    np.testing.assert_array_equal(found.segments, [[0, 2]])  # 1.125 and 0.825 mm, at 1 mm


def varied(shot, factors, material=None, **touching):
    """Return a shot of hair with a map of factors, one a strand, on settings of contact that name it."""
    groom = replace(shot.hair.groom, maps={"own": np.array(factors)})
    shot.hair = build_hair(groom, material or Material(), "rod")
    shot.scene = replace(shot.scene, **touching)
    shot.state = start(shot.hair, shot.body, shot.scene)
    return shot


def crossing(x, y=0.03, count=25):
    """A hair that falls across another one, from a place along x."""
    along = np.linspace(0.0, 1.0, count)[:, None]
    return [[x, 0.0, 0.0] + along * [0.045, 0, 0], [x + y, -2.0e-3, -0.02] + along * [0, 0, 0.03]]


def lowest_gap(shot):
    pairs = near_pairs(shot.axis, shot.hair.layout.offsets, 4e-3)
    strands = np.searchsorted(shot.hair.layout.offsets, pairs.segments, side="right") - 1
    return pairs.distances[strands[:, 0] != strands[:, 1]].min()


def fallen(scene, strands, factors, touching):
    shot = scene(strands, step=1 / 96, drag=8.0, model="rod")
    return varied(shot, factors, **touching).run(0.75)


def test_a_thick_hair_rests_on_a_thin_one_at_their_mean_thickness(scene):
    """As two hairs of that thickness do, up to what friction holds: times of contact follow the setting."""
    unequal = fallen(scene, crossing(0.0), (1.0, 0.2), {"collisions": Collisions(Thickness(1e-3, map="own"))})
    equal = fallen(scene, crossing(0.0), (1.0, 1.0), {"collisions": Collisions(Thickness(6e-4))})
    assert 0.9 * 6e-4 < lowest_gap(unequal) < 1.05 * 6e-4
    np.testing.assert_allclose(unequal.axis, equal.axis, rtol=0, atol=1e-4)


def test_pairs_of_two_thicknesses_in_one_groom_rest_as_each_alone(scene):
    touching = {"collisions": Collisions(Thickness(1e-3, map="own"))}
    both = fallen(scene, [*crossing(0.0), *crossing(1.0)], (1.0, 1.0, 0.3, 0.3), touching).axis.reshape(2, 50, 3)
    for place, (found, thickness) in enumerate(zip(both, (1e-3, 3e-4), strict=True)):
        alone = fallen(scene, crossing(float(place)), (1, 1), {"collisions": Collisions(Thickness(thickness))})
        np.testing.assert_allclose(found, alone.axis, rtol=0, atol=1.5e-4)  # of 0.7 mm between the two
        assert 0.8 * thickness < lowest_gap(alone) < 1.1 * thickness


def test_hair_without_force_connects_to_nothing(scene, straight):
    lines = [straight(0.05, 10, [1, 0, 0]) + np.array([0, 0, 4e-4 * k]) for k in range(3)]
    touching = {"stiction": Stiction(reach=1e-3, release=2e-3, force=Force(2e-5, map="own"))}
    stuck = varied(scene(lines, model="rod"), (1.0, 0.0, 0.5), **touching).run(1 / 24).state.stuck // 11
    assert len(stuck) and set(map(tuple, stuck)) == {(0, 2)}


def test_factors_of_contact_are_those_of_the_values(scene, straight):
    lines = [straight(0.05, 4, [1, 0, 0]) + np.array([0, 0, 0.01 * k]) for k in range(2)]
    profile = ((0.0, 1.0), (1.0, 0.2))
    touching = {
        "stiction": Stiction(force=Force(2e-5, map="own", profile=profile)),
        "collisions": Collisions(Thickness(4e-4, profile=profile)),
    }
    shot = varied(scene(lines, model="rod"), (1.0, 0.25), **touching)
    around = surroundings_of(shot.hair, shot.hair.model, shot.state, (), shot.scene, 0.0)
    contacts = next(each for each in around.interactions if isinstance(each, HairContacts))
    along = np.array([0.9, 0.7, 0.5, 0.3])  # of the profile, in the middle of the four segments
    forces = contacts.stiction.force.value * contacts.grips**2
    np.testing.assert_allclose(forces.reshape(2, 5)[:, :4], 2e-5 * np.outer([1.0, 0.25], along))
    thickness = contacts.collisions.thickness.value * contacts.thick
    np.testing.assert_allclose(thickness.reshape(2, 5)[:, :4], 4e-4 * np.tile(along, (2, 1)))
