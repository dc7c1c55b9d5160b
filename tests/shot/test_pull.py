"""Goals compared with closed forms: an oscillator, and a beam on an elastic foundation."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.laws.settings import Frequency, Goal, Scheme
from hairpipe.measure.motion import measure_impulses
from hairpipe.shot.build import with_interactions
from hairpipe.shot.goals import frequencies_of, goals_of
from hairpipe.shot.lock_guides import take_guides
from hairpipe.shot.shot import Frame, next_state
from hairpipe.shot.simulate import StrandSimulation, advance_frame, start
from hairpipe.strands.layout import axis_of
from hairpipe.strands.material import Material
from hairpipe.values import Pins

from ..strand_scenes import plate

FRAME = 1 / 24
SCHEMES = ("tr_bdf2", "bdf2", "backward_euler", "nine_steps")


def advanced(shot, frames, goal, pins=(), body=None):
    """Advance a shot by frames under a goal; body(n) is the body at frame n."""
    shot.scene = replace(shot.scene, goal=goal)
    for n in range(frames):
        drivers = (shot.body, shot.body) if body is None else (body(n), body(n + 1))
        frame = Frame(drivers, (), (), n * FRAME, FRAME, pins=[(pins, pins)] if pins else ())
        shot.state = next_state(StrandSimulation(shot.hair, shot.scene), shot.state, frame)
    return shot


def loose(scene, straight, scheme="tr_bdf2", step=1 / 240):
    """Points without springs between them: nothing but goals acts on them."""
    shot = scene([straight(0.1, 5, [1, 0, 0])], model="chain", gravity=0.0, step=step, scheme=Scheme(scheme))
    shot.scene = replace(shot.scene, strain=None)
    shot.hair = replace(shot.hair, model=shot.hair.model._replace(constants=0.0 * shot.hair.model.constants))
    return shot


def oscillation(time, frequency, damping):
    """The place at a time of an oscillator that begins at 1 without velocity, and its velocity."""
    omega = 2 * np.pi * frequency
    roots = -omega * (damping + np.array([1, -1]) * np.sqrt(complex(damping**2 - 1)))
    shares = np.array([-roots[1], roots[0]]) / (roots[0] - roots[1])
    return (shares * np.exp(roots * time)).sum().real, (shares * roots * np.exp(roots * time)).sum().real


def error_of_oscillator(scene, straight, scheme, step, damping=0.2):
    shot = loose(scene, straight, scheme, step)
    away = np.array([0.0, 3e-3, 0.0])
    moved = shot.state.positions.copy()
    moved[shot.hair.layout.shape.clamped :] += away[:, None]
    shot.state = replace(shot.state, positions=moved, fresh=np.ones_like(shot.state.fresh))
    advanced(shot, 6, Goal(Frequency(3.0), damping))
    rest = shot.hair.groom.points
    expected = rest[1:] + away * oscillation(6 * FRAME, 3.0, damping)[0]
    return np.abs(shot.axis[1:] - expected).max() / 3e-3


@pytest.mark.parametrize(("scheme", "order"), [("tr_bdf2", 2), ("bdf2", 2), ("backward_euler", 1)])
def test_a_point_oscillates_about_its_goal_with_the_order_of_the_scheme(scene, straight, scheme, order):
    errors = [error_of_oscillator(scene, straight, scheme, FRAME / steps) for steps in (16, 32, 64)]
    found = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < (0.003 if order == 2 else 0.1)
    np.testing.assert_allclose(found[-1], order, atol=0.2)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_stiff_goal_is_stable_at_long_steps(scene, straight, scheme):
    """60 Hz at steps of 1/24 s: explicit steps would have to be 40 times shorter."""
    shot = loose(scene, straight, scheme, FRAME)
    moved = shot.state.positions.copy()
    moved[shot.hair.layout.shape.clamped :, 1] += 3e-3
    shot.state = replace(shot.state, positions=moved, fresh=np.ones_like(shot.state.fresh))
    away = [
        np.abs(advanced(shot, 1, Goal(Frequency(60.0), 0.0)).axis - shot.hair.groom.points).max() for _ in range(24)
    ]
    assert max(away) < 1.001 * 3e-3


def turned(angle, centre=np.zeros(3), shift=np.zeros(3)):  # noqa: B008
    """The plate turned about an axis, with the velocity of 2 rad/s about it."""
    axis = np.array([0.2, 0.5, 0.8]) / np.linalg.norm([0.2, 0.5, 0.8])
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(3) - np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    still = plate()
    points = (still.points - centre) @ turn.T + centre + shift
    return plate(points, np.cross(2.0 * axis, points - centre)), turn


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("fresh", [False, True])
def test_its_impulse_is_the_change_of_momentum(scene, straight, scheme, fresh):
    """Points that nothing else pulls follow a body that turns, several steps a frame."""
    shot = loose(scene, straight, scheme, 1 / 100)
    moving = start(shot.hair, turned(0.0)[0], shot.scene)
    shot.state = replace(shot.state, fresh=np.ones_like(shot.state.fresh)) if fresh else moving
    masses = shot.hair.model.mass[shot.hair.layout.shape.clamped :, :1]
    for n in range(4):
        before = shot.state.velocities[shot.hair.layout.shape.clamped :, :, 0]
        advanced(shot, 1, Goal(Frequency(5.0), 0.7), body=lambda k, n=n: turned(2.0 * FRAME * (n + k))[0])
        after = shot.state.velocities[shot.hair.layout.shape.clamped :, :, 0]
        change = (masses * (after - before)).sum(axis=0)
        assert np.abs(change).max() > 1e-10
        np.testing.assert_allclose(shot.state.impulses[0], change, rtol=0, atol=1e-12 * np.abs(masses * after).sum())


def test_force_is_the_negative_gradient_of_its_energy(scene, straight):
    shot = loose(scene, straight)
    (pull,) = goals_of(shot.hair, (shot.body, shot.body), (), Goal(Frequency(7.0), 0.3), FRAME)
    rng = np.random.default_rng(4)
    x = shot.axis + 1e-3 * rng.standard_normal(shot.axis.shape)

    def energy(points):
        away = points[pull.springs.points] - shot.hair.groom.points
        return 0.5 * (pull.springs.stiffness[:, None] * away**2).sum()

    force = pull.force(x, np.zeros_like(x), 0.0)
    for k, c in ((2, 0), (5, 1)):
        step = np.zeros_like(x)
        step[k, c] = 1e-6
        assert force[k, c] == pytest.approx(-(energy(x + step) - energy(x - step)) / 2e-6, rel=1e-6)


def beam_on_foundation(length, bending, foundation, load, count=4000):
    """Solve E I w'''' + k w = load for a clamped beam with a free end, by finite differences: w at all nodes."""
    from scipy.sparse import diags
    from scipy.sparse.linalg import spsolve

    h = length / count
    second = diags([1.0, -2.0, 1.0], [-1, 0, 1], shape=(count, count + 1)).tolil()  # curvature at nodes 0 .. count - 1
    second[0, :2] = [-2.0, 2.0]  # clamped: the ghost equals the neighbour
    second = second.tocsr()[:, 1:] / h**2
    weights = np.full(count, h)
    weights[0] = h / 2
    ends = np.full(count, h)
    ends[-1] = h / 2
    stiffness = bending * second.T @ diags(weights) @ second + diags(foundation * ends)
    return np.concatenate([[0.0], spsolve(stiffness.tocsc(), load * ends)])


@pytest.mark.parametrize("model", ["rod", "network"])
def test_hair_sags_as_a_beam_on_an_elastic_foundation(scene, straight, model):
    """Weight against bending and goal; independent: E I w'''' + rho A (2 pi f)^2 w = rho A g."""
    shot = scene([straight(0.1, 25, [1, 0, 0])], model=model, step=1 / 96, drag=5.0)
    advanced(shot, 36, Goal(Frequency(6.0), 1.0))
    material = Material()
    density, omega = material.line_density, 2 * np.pi * 6.0
    exact = beam_on_foundation(0.1, material.bending, density * omega**2, density * 9.81)
    sag = shot.hair.groom.points[:, 1] - shot.axis[:, 1]
    np.testing.assert_allclose(sag[1:], exact[160::160], atol=0.01 * exact.max())
    assert np.abs(shot.state.velocities).max() < 1e-4  # and it has come to rest


def pins_at(points, rest, frequency=60.0):
    """Pins that keep some points of a groom where they are at rest."""
    positions = np.asarray(rest, float)[points]
    return Pins(np.array(points, np.int32), positions, np.zeros_like(positions), frequency, 1.0, len(rest))


@pytest.mark.parametrize("model", ["rod", "network"])
def test_a_pinned_point_stays_while_the_rest_falls(scene, straight, model):
    shot = scene([straight(0.1, 10, [1, 0, 0]), straight(0.1, 10, [1, 0, 0.3])], model=model, step=1 / 96, drag=5.0)
    rest = shot.hair.groom.points
    moved = advanced(shot, 12, None, pins_at([5], rest)).axis - rest
    assert np.linalg.norm(moved[5]) < 1e-3  # the weight that it carries over its stiffness
    assert moved[10, 1] < -0.01 and moved[16, 1] < -0.01
    assert shot.state.impulses[0, 1] > 0.0 and not shot.state.impulses[1].any()


def test_pins_of_another_groom_are_refused(scene, straight):
    shot = scene([straight(0.1, 10, [1, 0, 0])], step=1 / 96)
    with pytest.raises(BadInput, match=r"pins of a groom of 12 points, for one of 11.*the groom that is simulated"):
        advanced(shot, 1, None, pins_at([5], np.zeros((12, 3))))


def test_a_goal_does_not_depend_on_the_direction_of_space(scene, straight):
    """Hair on a turning body, seen from a turned frame: without weight the result turns with it."""
    tips = []
    for turn in (np.eye(3), turned(1.0)[1]):
        shot = scene([straight(0.1, 10, [1, 0, 0.4])], model="rod", gravity=0.0, step=1 / 96)

        def body(n, turn=turn):
            mesh = turned(2.0 * n * FRAME)[0]
            return plate(mesh.points @ turn.T, mesh.rates @ turn.T)

        shot.state = start(shot.hair, body(0), shot.scene)
        tips.append(
            advanced(shot, 6, Goal(Frequency(3.0, profile=((0.0, 1.0), (1.0, 0.3))), 0.5), body=body).axis @ turn
        )
    np.testing.assert_allclose(*tips, atol=1e-9)
    assert np.abs(tips[0] - shot.hair.groom.points).max() > 0.01


def test_strength_follows_the_profile_and_the_groups(scene, straight):
    shot = scene([straight(0.1, 10, [1, 0, 0]), straight(0.1, 10, [1, 0, 0.3])])
    groom = replace(shot.hair.groom, groups=np.array([1, 0], np.int32), group_names=("beard", "fringe"))
    hair = replace(shot.hair, groom=groom)
    profile = ((0.0, 1.0), (0.5, 1.0), (1.0, 0.0))
    goal = Goal(Frequency(4.0, profile=profile, map="fringe"))
    expected = [4.0] * 6 + [3.2, 2.4, 1.6, 0.8, 0.0] + [0.0] * 11
    np.testing.assert_allclose(frequencies_of(goal, hair), expected, atol=1e-6)
    with pytest.raises(BadInput, match="'tail'"):
        frequencies_of(Goal(Frequency(4.0, groups=(("tail", 0.0),))), hair)
    np.testing.assert_array_equal(frequencies_of(Goal(Frequency(4.0)), hair), 4.0)


def test_guides_are_pulled_as_they_are_among_all_strands(scene, straight):
    """Of some strands, pins and goals are those of these strands."""
    strands = [straight(0.1, 6, [1, 0, z]) for z in (0.0, 0.1, 0.2)]
    whole = scene(strands, step=1 / 96)
    rest = whole.hair.groom.points
    advanced(whole, 2, Goal(Frequency(3.0)), pins_at([3, 17], rest))
    part = take_guides(whole.hair, np.array([0, 0, 2], np.int32))
    lone = scene(strands, step=1 / 96)
    state = part.state_of(lone.state)
    for n in range(2):
        pins = pins_at([3, 17], rest)
        goals = goals_of(part.hair, (lone.body, lone.body), [(pins, pins)], Goal(Frequency(3.0)), FRAME)
        held = with_interactions(whole.scene, *goals)
        state = advance_frame(part.hair, state, (lone.body, lone.body), (), FRAME, held, n * FRAME)
    back = part.put(lone.state, state)
    found = axis_of(whole.hair.layout).gather(back.positions)
    np.testing.assert_array_equal(found[:7], whole.axis[:7])
    np.testing.assert_array_equal(found[14:], whole.axis[14:])
    np.testing.assert_array_equal(back.impulses[[0, 2]], whole.state.impulses[[0, 2]])
    assert not back.impulses[1].any()


def test_its_impulses_are_tabulated_by_group(scene, straight):
    shot = scene([straight(0.1, 10, [1, 0, 0]), straight(0.1, 10, [1, 0, 0.3])], step=1 / 96)
    groom = replace(shot.hair.groom, groups=np.array([1, 0], np.int32), group_names=("beard", "fringe"))
    states = {1001: shot.state, 1002: advanced(shot, 1, Goal(Frequency(3.0))).state}
    everything, fringe = (measure_impulses(groom, states, group, 24.0) for group in (None, "fringe"))
    assert everything["impulse y [N s]"][0] == 0.0 and everything["impulse y [N s]"][1] > 0.0
    assert fringe["impulse y [N s]"][1] == pytest.approx(shot.state.impulses[0, 1])
    assert fringe["mean force [N]"][1] == pytest.approx(24.0 * np.linalg.norm(shot.state.impulses[0]))
