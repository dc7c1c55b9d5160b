"""Hair that stands as groomed, and hair at rest under gravity, against statics and the simulation."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.graphs.experiments.studies.theory.elastica import bend_elastica
from hairpipe.laws.settings import Construction, SagFree
from hairpipe.shot.simulate import advance_frame, start
from hairpipe.solve.sag_free import STEP, assemble, find_equilibrium, find_initial_state, find_stable, tangent
from hairpipe.solve.settle import STILL, settle, settle_groom
from hairpipe.strands.hair_model import build_hair
from hairpipe.strands.material import Material

GRAVITY = np.array([0.0, -9.81, 0.0])
OUT, UP, DOWN = [1, 0, 0], [0, 1, 0], [0, -1, 0]


def curl(radius=0.003, pitch=0.012, length=0.15, segments=75):
    """A curl that hangs."""
    return wound(Helix(radius=radius, pitch=pitch), length, segments) @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.fixture
def sag_free(scene):
    """A shot with a sag-free start, and what was said about it."""

    def make(strands, wanted=SagFree(), **settings):  # noqa: B008 (frozen)
        s = scene(strands, **settings)
        s.scene = replace(s.scene, sag_free=wanted)
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
    s = sag_free([straight(0.1, 25, OUT), straight(0.3, 25, OUT)], SagFree(unstable="settle"))
    assert len(s.reported) == 1
    before = s.axis
    assert before[51, 1] < -0.25
    moved = s.run(1.0).axis - before
    assert np.sqrt(np.mean(np.sum(moved**2, axis=1))) < 1e-6


def test_settled_strands_start_with_the_body(sag_free, straight, triangle):
    """About the plumb line: what hangs under its root goes with it, and does not fly as what it was groomed would."""
    s = sag_free([straight(0.3, 25, OUT)], SagFree(unstable="settle"))
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
        sag_free([straight(0.1, 25, OUT), straight(0.3, 25, OUT)], SagFree(unstable="refuse"))


def test_springs_strained_too_much_do_not_stand(sag_free, straight):
    assert not sag_free([straight(0.1, 50, OUT)], SagFree(strain=0.06)).reported
    assert sag_free([straight(0.1, 50, OUT)], SagFree(strain=0.03)).reported


def test_a_chain_cannot_hold_a_groom(sag_free, straight):
    with pytest.raises(BadInput, match="network"):
        sag_free([straight(0.1, 10, DOWN)], model="chain")


def test_a_strand_that_is_not_finite_does_not_take_others_along(scene, straight):
    hair = scene([straight(0.1, 25, OUT), straight(0.1, 25, OUT)]).hair
    lost = hair.rest.copy()
    lost[20, :, 0] = np.nan
    with pytest.warns(UserWarning, match="1 of 2 strands .* and fall: strands 0"):
        initial = find_initial_state(hair.model, hair.layout, hair.groom.ids, lost, GRAVITY, SagFree())
    np.testing.assert_array_equal(initial.inverse_lengths[..., 0], hair.model.inverse_lengths[..., 0])
    found = find_equilibrium(hair.model, hair.rest, GRAVITY)
    np.testing.assert_array_equal(initial.tensions[..., 1], found.tensions[..., 1])


def test_result_does_not_depend_on_threads_or_other_strands(sag_free, straight, same_on_threads):
    strands = [straight(0.02 * (i + 1), 25, [1, 0.1 * i, 0]) for i in range(12)]
    wanted = SagFree(unstable="settle")
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
    hair, sag_free = build_hair(groom, Material(), "network"), replace(s.scene, sag_free=SagFree())
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
