"""Hair that stands as groomed, and hair at rest under gravity, against statics and the simulation."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica
from hairpipe.laws.settings import Construction, Rest, Share
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.solve.sag_free import STEP, assemble, find_equilibrium, find_initial_state, find_stable, tangent
from hairpipe.solve.settle import STILL, settle, settle_groom
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

BALANCED = Rest(balanced=Share(1.0))
GRAVITY = np.array([0.0, -9.81, 0.0])
OUT, UP, DOWN = [1, 0, 0], [0, 1, 0], [0, -1, 0]


def curl(radius=0.003, pitch=0.012, length=0.15, segments=75):
    """A curl that hangs."""
    return wound(Helix(radius=radius, pitch=pitch), length, segments) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.fixture
def sag_free(scene):
    """A shot with a sag-free start, and what was said about it."""

    def make(strands, wanted=BALANCED, **settings):
        s = scene(strands, **settings)
        s.scene = replace(s.scene, rest=wanted)
        with warnings.catch_warnings(record=True) as reported:
            warnings.simplefilter("always")
            s.state = start(s.hair, s.body, s.scene)
        s.reported = [str(w.message) for w in reported]
        return s

    return make


def is_stable(hair):
    """The verdict on a pose, beside the smallest eigenvalue of its tangent."""
    found = find_equilibrium(hair.model, hair.rest, GRAVITY)
    model = hair.model._replace(inverse_lengths=found.inverse_lengths)
    lanes = hair.rest.shape[2]
    steps = np.full((1, lanes), STEP * np.linalg.norm(hair.rest[2, :, 0] - hair.rest[0, :, 0]))
    bands = tangent(model, 0, hair.rest, steps)[:, :, 0]
    matrix = np.zeros((len(bands), len(bands)))
    for k, band in enumerate(bands.T):
        matrix += np.diag(band[: len(band) - k], k)
    matrix = (matrix + np.triu(matrix, 1).T)[9:, 9:]
    stable = np.empty((1, lanes))
    find_stable(model, hair.rest, steps, stable)
    return bool(stable[0, 0]), np.linalg.eigvalsh(matrix)[0]


@pytest.mark.parametrize("softening", [1.0, 100.0])
def test_groomed_strands_are_in_equilibrium_to_rounding(scene, straight, softening):
    strands = [straight(0.3, 50, DOWN), straight(0.1, 50, OUT), straight(0.05, 50, UP), straight(0.3, 50, OUT)]
    hair = scene([*strands, curl(segments=50)], Material(softening=softening)).hair
    found = find_equilibrium(hair.model, hair.rest, GRAVITY)
    model = hair.model._replace(inverse_lengths=found.inverse_lengths)
    left = (
        assemble(model, 0, hair.rest, np.zeros_like(model.inverse_lengths), 0)[1]
        + hair.model.mass[:, None] * GRAVITY[:, None]
    )
    assert np.abs(left[3:]).max() < 1e-14
    assert hair.model.mass.min() * 9.81 > 1e-9


@pytest.mark.parametrize(
    ("length", "direction", "stable"),
    [
        (0.05, DOWN, True),
        (0.05, OUT, True),
        (0.05, UP, True),
        (0.1, DOWN, True),
        (0.1, OUT, True),
        (0.1, UP, False),
        (0.15, OUT, False),
        (0.2, OUT, False),
        (0.3, OUT, False),
        (0.3, DOWN, True),
    ],
)
@pytest.mark.parametrize("softening", [1.0, 100.0])
def test_verdict_is_that_of_the_prototype_and_of_the_eigenvalues(scene, straight, length, direction, stable, softening):
    hair = scene([straight(length, 50, direction)], Material(softening=softening)).hair
    verdict, smallest = is_stable(hair)
    assert verdict == stable == (smallest > 0)


@pytest.mark.parametrize("shape", [(0.003, 0.012, 0.15, 75), (0.003, 0.012, 0.1, 50), (0.015, 0.03, 0.3, 75)])
def test_hanging_curls_stand(scene, shape):
    """Their lattice may be a thousandth of a segment from exchanging altitude springs."""
    verdict, smallest = is_stable(scene([curl(*shape)]).hair)
    assert verdict and smallest > 0


def test_an_upright_hair_falls_where_theory_says(scene, straight):
    """Greenhill: a column buckles under its weight where rho A g L^3 / (E I) = 7.837."""
    material = Material()
    critical = (7.8373 * material.bending / (material.line_density * 9.81)) ** (1 / 3)
    assert is_stable(scene([straight(0.97 * critical, 50, UP)]).hair)[0]
    assert not is_stable(scene([straight(1.03 * critical, 50, UP)]).hair)[0]


@pytest.mark.parametrize("step", [1 / 240, 1 / 24])
def test_sag_free_strands_are_unchanged_after_two_seconds(sag_free, straight, step):
    strands = [straight(0.3, 50, DOWN), straight(0.1, 50, OUT), straight(0.07, 30, [1, 1, 0]), curl(0.002, 0.02, 0.1)]
    s = sag_free(strands, step=step)
    assert not s.reported
    before = s.axis
    np.testing.assert_array_equal(before, s.hair.layout.axis(s.hair.rest))
    moved = s.run(2.0).axis - before
    assert np.sqrt(np.mean(np.sum(moved**2, axis=1))) < 1e-6
    assert np.abs(s.state.velocities).max() < 1e-4


def test_without_it_hair_sags(scene, straight):
    s = scene([straight(0.1, 50, OUT)])
    before = s.axis
    assert np.abs(s.run(0.1).axis - before).max() > 0.01


def test_unstable_strands_are_named_and_fall(sag_free, scene, straight):
    strands = [straight(0.1, 25, OUT), straight(0.3, 25, OUT), straight(0.3, 25, DOWN)]
    s = sag_free(strands)
    assert s.reported == ["1 of 3 strands have no stable equilibrium as groomed and fall: strands 1"]
    alone = scene([strands[1]])
    before = s.points
    after = s.run(0.25).points
    np.testing.assert_array_equal(after[26:52], alone.run(0.25).points)
    kept = np.r_[0:26, 52:78]
    np.testing.assert_allclose(after[kept], before[kept], atol=1e-6)


def test_unstable_strands_may_settle(sag_free, straight):
    s = sag_free([straight(0.1, 25, OUT), straight(0.3, 25, OUT)], replace(BALANCED, unstable="settle"))
    assert len(s.reported) == 1
    before = s.axis
    assert before[51, 1] < -0.25
    moved = s.run(1.0).axis - before
    assert np.sqrt(np.mean(np.sum(moved**2, axis=1))) < 1e-6


def test_settled_strands_start_with_the_body(sag_free, straight, triangle):
    """About the plumb line: what hangs under its root goes with it, and does not fly as what it was groomed would."""
    s = sag_free([straight(0.3, 25, OUT)], replace(BALANCED, unstable="settle"))
    middle = triangle().points.mean(0)
    turning = triangle(velocities=np.cross([0.0, 5.0, 0.0], triangle().points))
    with pytest.warns(UserWarning, match="settle"):
        state = start(s.hair, turning, s.scene)
    np.testing.assert_allclose(state.positions, s.state.positions, atol=1e-12)
    speeds = np.linalg.norm(s.hair.layout.axis(state.velocities), axis=1)
    expected = np.linalg.norm(np.cross([0.0, 5.0, 0.0], s.axis), axis=1)
    np.testing.assert_allclose(speeds, expected, atol=1e-5)
    assert np.abs(s.axis[-1] - middle)[0] < 0.1


def test_unstable_strands_may_be_refused(sag_free, straight):
    with pytest.raises(BadInput, match=r"1 of 2 strands have no stable equilibrium.*: strands 1"):
        sag_free([straight(0.1, 25, OUT), straight(0.3, 25, OUT)], replace(BALANCED, unstable="refuse"))


def test_springs_strained_too_much_do_not_stand(sag_free, straight):
    assert not sag_free([straight(0.1, 50, OUT)], replace(BALANCED, strain=0.06)).reported
    assert sag_free([straight(0.1, 50, OUT)], replace(BALANCED, strain=0.03)).reported


def test_a_chain_cannot_hold_a_groom(sag_free, straight):
    with pytest.raises(BadInput, match="network"):
        sag_free([straight(0.1, 10, DOWN)], model="chain")


def test_a_strand_that_is_not_finite_does_not_take_others_along(scene, straight):
    hair = scene([straight(0.1, 25, OUT), straight(0.1, 25, OUT)]).hair
    whole = np.ones(hair.layout.strands.shape)
    lost = hair.rest.copy()
    lost[20, :, 0] = np.nan
    with pytest.warns(UserWarning, match="1 of 2 strands .* and fall: strands 0"):
        initial = find_initial_state(hair.model, hair.layout, hair.groom.ids, lost, GRAVITY, BALANCED, whole)
    np.testing.assert_array_equal(initial.inverse_lengths[..., 0], hair.model.inverse_lengths[..., 0])
    found = find_equilibrium(hair.model, hair.rest, GRAVITY)
    np.testing.assert_array_equal(initial.tensions[..., 1], found.tensions[..., 1])


def test_result_does_not_depend_on_threads_or_other_strands(sag_free, straight, same_on_threads):
    strands = [straight(0.02 * (i + 1), 25, [1, 0.1 * i, 0]) for i in range(12)]
    wanted = replace(BALANCED, unstable="settle")
    many = same_on_threads(lambda: sag_free(strands, wanted).run(1 / 24).points)
    for i in (0, 5, 11):
        np.testing.assert_array_equal(sag_free([strands[i]], wanted).run(1 / 24).points, many[26 * i : 26 * (i + 1)])


def test_equilibrium_is_at_the_first_frame(sag_free, straight, triangle):
    """The body has turned since the groom was made: gravity is carried in the new pose."""
    s = sag_free([straight(0.1, 25, DOWN)])
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    body = triangle(triangle().points @ turn.T)
    hair = build_hair(s.hair.groom, Material(), "network")
    state = before = start(hair, body, s.scene)
    for _ in range(24):
        state = advance_frame(hair, state, (body, body), (), 1 / 24, s.scene)
    np.testing.assert_allclose(state.positions, before.positions, atol=1e-6)


@pytest.fixture
def settled(scene):
    """Hair of these strands, and where it settles."""

    def run(strands, **settings):
        hair = scene(strands, **settings).hair
        everyone = np.ones(hair.layout.strands.shape, bool)
        return hair, settle(hair.model, hair.layout, hair.groom.ids, hair.rest, GRAVITY, everyone)

    return run


@pytest.mark.parametrize("gamma", [0.3, 3.0, 30.0, 1000.0])
@pytest.mark.parametrize("model", ["network", "chain"])
def test_it_finds_the_elastica(settled, straight, gamma, model):
    material = Material()
    length = (gamma * material.bending / (material.line_density * 9.81)) ** (1 / 3)
    hair, found = settled([straight(length, 50, [1, 0, 0])], material=material, model=model)
    axis = hair.layout.axis(found.positions)
    tip = (axis[-1] - axis[0]) / length
    np.testing.assert_allclose(tip, [*bend_elastica(gamma).tip, 0.0], atol=0.01)


def test_no_force_is_left(settled, straight):
    hair, found = settled([straight(0.3, 50, [1, 0, 0]), straight(0.1, 50, [1, 1, 0]), straight(0.3, 50, [0.05, 1, 0])])
    forces = assemble(hair.model, 0, found.positions, found.tensions, 0)[1]
    left = forces + hair.model.mass[:, None] * GRAVITY[:, None]
    mass = hair.model.mass[3:].sum(0)
    assert np.all(np.abs(left[3:]) <= 1.01 * STILL * mass)
    assert np.all(found.left <= STILL)


@pytest.mark.parametrize("model", ["network", "chain"])
def test_it_is_where_the_simulation_comes_to_rest(settled, scene, straight, model):
    strands = [straight(0.1, 25, [1, 0, 0]), straight(0.3, 25, [1, -0.3, 0])]
    hair, found = settled(strands, model=model)
    axis = scene(strands, drag=15.0, model=model).run(6.0).axis
    np.testing.assert_allclose(hair.layout.axis(found.positions), axis, atol=1e-4)


def test_the_settled_groom_keeps_its_shape_when_it_is_simulated_sag_free(scene, straight):
    s = scene([straight(0.1, 50, [1, 0, 0]), straight(0.3, 50, [1, 0, 0]), curl()])
    groom = settle_groom(s.hair.groom, Material(), Construction(), 9.81, "network")
    np.testing.assert_array_equal(groom.points[groom.offsets[:-1]], s.hair.groom.points[groom.offsets[:-1]])
    hair, sag_free = build_hair(groom, Material(), "network"), replace(s.scene, rest=BALANCED)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        state = start(hair, s.body, sag_free)
    for _ in range(48):
        state = advance_frame(hair, state, (s.body, s.body), (), 1 / 24, sag_free)
    moved = hair.layout.axis(state.positions) - groom.points
    assert np.sqrt(np.mean(np.sum(moved**2, axis=1))) < 1e-6


def test_those_that_are_not_asked_stay(settled, straight):
    hair, _ = settled([straight(0.1, 25, [1, 0, 0]), straight(0.2, 25, [1, 0, 0])])
    who = hair.layout.strands == 1
    found = settle(hair.model, hair.layout, hair.groom.ids, hair.rest, GRAVITY, who)
    axis = hair.layout.axis(found.positions)
    np.testing.assert_array_equal(axis[:26], hair.groom.points[:26])
    assert np.linalg.norm(axis[-1] - hair.groom.points[-1]) > 0.1


def test_moving_strands_are_named(settled, straight):
    hair, found = settled([straight(0.1, 25, [1, 0.1, 0]), straight(0.1, 25, [1, 0, 0])])
    lost, everyone = hair.rest.copy(), np.ones(hair.layout.strands.shape, bool)
    lost[20, :, 1:] = np.nan
    with pytest.warns(UserWarning, match="1 of 2 strands have not come to rest: strands 1"):
        again = settle(hair.model, hair.layout, hair.groom.ids, lost, GRAVITY, everyone)
    np.testing.assert_array_equal(again.positions[..., 0], found.positions[..., 0])


def test_it_depends_neither_on_threads_nor_on_other_strands(settled, straight, same_on_threads):
    strands = [straight(0.02 * (i + 1), 25, [1, 0.1 * i, 0]) for i in range(12)]

    def points_of(strands):
        hair, found = settled(strands)
        return hair.layout.axis(found.positions)

    many = same_on_threads(lambda: points_of(strands))
    for i in (0, 5, 11):
        np.testing.assert_array_equal(points_of([strands[i]]), many[26 * i : 26 * (i + 1)])


@pytest.mark.parametrize("model", ["rod", "network"])
@pytest.mark.parametrize("share", [0.4, 1.0])
def test_a_share_of_the_weight_is_balanced_under_that_share_of_gravity(scene, straight, model, share):
    hair = scene([straight(0.1, 25, OUT)], model=model).hair
    shares = np.full(hair.layout.strands.shape, share)
    found = find_initial_state(hair.model, hair.layout, hair.groom.ids, hair.rest, GRAVITY, BALANCED, shares)
    springs = hair.model._replace(inverse_lengths=found.inverse_lengths)
    forces = assemble(springs, 0, hair.rest, found.tensions, 0)[1][:, :3]
    weight = hair.model.mass[:, None] * GRAVITY[:, None]
    free = slice(3, -1 if model == "rod" else None)  # a rod ends in a row that is not a node
    np.testing.assert_allclose((forces + share * weight)[free], 0.0, atol=1e-9 * np.abs(weight).sum())
    np.testing.assert_allclose(found.sags, 1.0 - share)


def test_the_dial_ends_in_the_groom_and_in_the_balance(scene, straight):
    hair = scene([straight(0.1, 25, OUT), curl(0.002, 0.02, 0.1)]).hair
    balance = find_equilibrium(hair.model, hair.rest, GRAVITY)
    for share, lengths, tensions in (
        (1.0, balance.inverse_lengths, balance.tensions),
        (0.0, hair.model.inverse_lengths, 0.0 * balance.tensions),
    ):
        shares = np.full(hair.layout.strands.shape, share)
        found = find_initial_state(hair.model, hair.layout, hair.groom.ids, hair.rest, GRAVITY, BALANCED, shares)
        np.testing.assert_array_equal(found.inverse_lengths, lengths)
        np.testing.assert_array_equal(found.tensions, tensions)
        np.testing.assert_array_equal(found.positions, hair.rest)


@pytest.mark.parametrize("model", ["rod", "network"])
def test_hair_that_starts_settled_stays_there(scene, straight, model):
    s = scene([straight(0.1, 25, OUT), straight(0.3, 25, [1, 0.4, 0])], model=model)
    s.scene = replace(s.scene, rest=Rest(start="settled"))
    s.state = start(s.hair, s.body, s.scene)
    before = s.axis
    assert before[25, 1] < s.hair.groom.points[25, 1] - 0.01
    assert s.state.inverse_lengths is None
    moved = s.run(0.5).axis - before
    assert np.sqrt(np.mean(np.sum(moved**2, axis=1))) < 1e-6


def test_a_settled_groom_that_is_balanced_is_straight_at_rest_as_groomed(scene, straight):
    """But for the stiffness E I / (l (1 + k^2 / 4)^2) of a vertex of bend k, which is that of the settled groom."""
    groom = scene([straight(0.1, 25, OUT), straight(0.15, 25, [1, 0.4, 0.2])]).hair.groom
    settled = settle_groom(groom, Material(), Construction(), 9.81, "rod")
    hung = build_hair(settled, Material(), "rod")
    found = find_equilibrium(hung.model, hung.rest, GRAVITY).inverse_lengths
    own, rest = (hung.layout.axis(v[:, 1:4])[np.r_[1:25, 27:51], :2] for v in (hung.model.inverse_lengths, found))
    own, rest = (np.linalg.norm(bends, axis=1) for bends in (own, rest))
    np.testing.assert_allclose(rest, own * ((1.0 + own**2 / 4.0) ** 2 - 1.0), atol=1e-5)


def test_hair_without_weight_settles_in_its_straight_rest_shape(scene):
    wavy = scene([curl(0.002, 0.02, 0.1)]).hair.groom
    ways = np.diff(settle_groom(wavy, Material(), Construction(), 0.0, "rod", shape=0.0).points, axis=0)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    np.testing.assert_allclose(ways, np.broadcast_to(ways[0], ways.shape), atol=1e-4)


def test_strands_that_are_straighter_than_groomed_cannot_be_balanced(scene, straight):
    s = scene([straight(0.1, 25, OUT), straight(0.1, 25, OUT)])
    groom = replace(s.hair.groom, maps={"held": np.array([0.0, 1.0])})
    hair = build_hair(groom, Material(), "rod")
    rest = Rest(shape=Share(1.0, profile=((0.0, 0.5),)), balanced=Share(1.0, map="held"))
    with pytest.raises(BadInput, match=r"shape below 1 contradicts balanced, .*: strands 1 "):
        start(hair, s.body, replace(s.scene, rest=rest))
    state = start(hair, s.body, replace(s.scene, rest=replace(rest, shape=Share(1.0))))
    changed = state.inverse_lengths != hair.model.inverse_lengths
    assert not changed[..., 0].any() and changed[..., 1].any()
