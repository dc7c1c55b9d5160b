"""No strand stops a shot: what a step cannot be solved for keeps its shape, is named, and spares the others."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.laws.settings import Collisions, Scheme, StepControl, StrainLimit, Thickness
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import next_state, start
from hairpipe.solve.lost import moved_rigidly
from hairpipe.strands.hair_model import build_hair, build_models
from hairpipe.strands.material import Material
from hairpipe.values import Ends

FRAME = 1 / 24
SOFT = Material(diameter=0.2e-3, young=2e6, density=1e4, softening=1.0)


def laid_over(segments, radius, before, after, aside):
    """A strand along z, and one that comes up beside it, goes half a turn about it, and down on the other side [m]."""
    along = np.stack([np.zeros(segments + 1), np.zeros(segments + 1), np.linspace(-0.05, 0.05, segments + 1)], axis=1)
    s = np.linspace(0, before + np.pi * radius + after, segments + 1)
    angle = np.clip((s - before) / radius, 0.0, np.pi)
    rest = np.minimum(s - before, 0.0) - np.maximum(s - before - np.pi * radius, 0.0)
    return along, np.stack([-radius * np.cos(angle), radius * np.sin(angle) + rest, np.full_like(s, aside)], axis=1)


def ends_of(groom):
    """Roots that stand, and the first tip held."""
    still = np.tile(np.eye(3, 4), (len(groom.ids), 1, 1))
    tips, rates = still.copy(), np.zeros_like(still)
    tips[1:] = rates[1:] = np.nan
    return Ends(still, np.zeros_like(still), tips, rates)


def stretch_of(hair, state):
    """Lengths of all segments over those of the groom."""
    ends = np.delete(np.arange(len(hair.groom.points) - 1), hair.layout.offsets[1:-1] - 1)
    now, rest = (
        np.linalg.norm(np.diff(points, axis=0), axis=1)[ends]
        for points in (hair.layout.axis(state.positions), hair.groom.points)
    )
    return now / rest


@pytest.mark.parametrize(
    ("shape", "step", "stiffness", "strain"),
    [
        ((100, 0.0055, 0.01, 0.02, 0.0123), 1 / 96, 0.1, StrainLimit()),
        ((100, 0.006, 0.0, 0.1, 0.0), 1 / 96, 1.0, None),
        ((100, 0.004, 0.01, 0.3, 0.001), 1 / 240, 0.1, StrainLimit()),
        ((50, 0.006, 0.2, 0.05, 0.001), 1 / 240, 10.0, None),
        ((100, 0.0051, 0.05, 0.5, 0.0), 1 / 240, 10.0, None),
        ((100, 0.005, 0.01, 0.5, 0.0123), 1 / 240, 1.0, None),
        ((50, 0.005, 0.01, 0.5, 0.001), 1 / 240, 0.1, None),
        ((50, 0.0051, 0.0, 0.3, 0.001), 1 / 240, 0.1, None),
    ],
)
def test_a_soft_heavy_rod_laid_over_another_folds_and_continues(scene, shape, step, stiffness, strain):
    """Its weight folds it over by nearly 180 degrees, where curvature has no bound."""
    hair = build_hair(scene(laid_over(*shape)).hair.groom, SOFT, "rod")
    shot = Scene(steps=StepControl(step), collisions=Collisions(Thickness(5e-3), stiffness=stiffness), strain=strain)
    driver, state, reported = ends_of(hair.groom), None, []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for number in range(9):
            state = next_state(hair, state, Frame((driver, driver), (), (), (number - 1) * FRAME, FRAME), shot)
        reported += [str(each.message) for each in caught]
    assert stretch_of(hair, state).max() < 2.0
    assert np.abs(state.velocities).max() < 5.0
    assert not any("had no solution" in each for each in reported)


def thrown(hair, body, shot, speed, frames=1):
    """Give the second strand a speed [m/s] that no step can be solved for; return the state and what was said."""
    state = start(hair, body, shot)
    state.velocities[hair.model.shape.clamped :, :, 1] = speed
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for number in range(frames):
            state = next_state(hair, state, Frame((body, body), (), (), number * FRAME, FRAME), shot)
    return state, [str(each.message) for each in caught]


@pytest.mark.parametrize("scheme", ["tr_bdf2", "bdf2", "backward_euler"])
@pytest.mark.parametrize("model", ["network", "rod"])
def test_a_strand_that_cannot_be_solved_is_held_and_named_and_spares_the_others(
    scene, straight, triangle, model, scheme
):
    strands = [straight(0.1, 10, [1, 0.2 * k, 0]) for k in range(3)]
    hair = build_hair(scene(strands).hair.groom, Material(), model)
    shot, body = Scene(steps=StepControl(longest=1 / 240), scheme=Scheme(scheme)), triangle()
    good, _ = thrown(hair, body, shot, 0.0)
    state, reported = thrown(hair, body, shot, 1e200)
    assert [each for each in reported if "1 of 3 strands had no solution in 1 of 10 steps of frame 1" in each]
    assert all("strands 1" in each for each in reported)
    points, others = hair.layout.axis(state.positions), hair.layout.axis(good.positions)
    np.testing.assert_array_equal(np.delete(points, slice(11, 22), 0), np.delete(others, slice(11, 22), 0))
    assert stretch_of(hair, state).max() < 1.01
    assert np.abs(points - others).max() < 0.01


def test_a_frame_in_which_single_precision_loses_a_strand_is_computed_in_double(scene, straight, triangle):
    """A speed whose square 32 bits do not hold; in double, too, the strand is held, as hair is not so long."""
    groom = scene([straight(0.1, 10, [1, 0.2 * k, 0]) for k in range(3)]).hair.groom
    models, body = build_models(groom, Material(), "network"), triangle()
    single, double = (models.in_precision(precision) for precision in ("single", "double"))
    shot = Scene(steps=StepControl(longest=1 / 240, travel=np.inf))
    (state, reported), (truth, alone) = (thrown(hair, body, shot, 1e20) for hair in (single, double))
    assert [each for each in reported if "strands 1 (in single precision): computed again in double precision" in each]
    assert not any("computed again" in each for each in alone)
    assert state.velocities.dtype == np.float32 and state.positions.shape == single.rest.shape
    ends = [hair.layout.axis(end.positions) for hair, end in ((single, state), (double, truth))]
    np.testing.assert_allclose(*ends, atol=1e-6)


def test_a_shot_diverges_where_no_strand_can_be_solved(scene, straight, triangle):
    hair = scene([straight(0.1, 10, [1, 0.2 * k, 0]) for k in range(3)]).hair
    body, shot = triangle(), replace(Scene(steps=StepControl(longest=1 / 240)), gravity=1e300)
    reported = r"diverged: 3 of 3 strands had no solution in 10 of 10 steps of frame 1: strands 0, 1, 2"
    with pytest.raises(ArithmeticError, match=reported):
        next_state(hair, start(hair, body, shot), Frame((body, body), (), (), 0.0, FRAME), shot)


@pytest.mark.parametrize("clamped", [2, 3])
def test_a_strand_is_carried_rigidly_with_its_clamp(clamped):
    """By a clamp of one edge no farther about it than that edge is turned."""
    random = np.random.default_rng(5)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    points, shift = random.normal(size=(9, 3)), np.array([1.0, -2.0, 3.0])
    there = moved_rigidly(points, points[:clamped] @ turn.T + shift)
    np.testing.assert_allclose(there[:clamped], points[:clamped] @ turn.T + shift, atol=1e-6)
    distances = [np.linalg.norm(each[:, None] - each[None], axis=2) for each in (points, there)]
    np.testing.assert_allclose(*distances, atol=1e-12)
    if clamped == 3:
        np.testing.assert_allclose(there, points @ turn.T + shift, atol=1e-6)
    else:
        still = moved_rigidly(points, points[:clamped] + shift)
        np.testing.assert_allclose(still, points + shift, atol=1e-12)
