"""No strand stops a shot: what a step cannot be solved for keeps its shape, is named, and spares the others."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from hairpipe.laws.settings import Collisions, Locks, Scheme, StepControl, Stiction, StrainLimit, Thickness, Volume
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame
from hairpipe.shot.simulate import next_state, start
from hairpipe.solve import lost
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


def thrown(hair, body, shot, speed, strand=1, state=None):
    """Advance a frame in which one strand begins with a speed [m/s]; return the state and what was said."""
    state = state or start(hair, body, shot)
    block, lane = np.argwhere(hair.layout.strands == strand)[0]
    rows, velocities = slice(hair.model.first[block], hair.model.first[block + 1]), state.velocities.copy()
    velocities[rows, :, lane][hair.model.shape.clamped :] = speed
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        after = next_state(hair, replace(state, velocities=velocities), Frame((body, body), (), (), 0.0, FRAME), shot)
    return after, [str(each.message) for each in caught]


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


SEGMENTS, LENGTH = 10, 0.1
STEPS = StepControl(longest=1 / 240, travel=np.inf)
UNSOLVED = "had no solution"


@pytest.fixture
def strands(scene, straight):
    """Hair of a model, of strands that leave one plate this far from each other [m]."""

    def make(count, model="chain", apart=0.01):
        lines = [straight(LENGTH, SEGMENTS, [1, 0.2, 0]) + np.array([0.0, 0.0, apart * k]) for k in range(count)]
        return build_hair(scene(lines).hair.groom, Material(), model)

    return make


@pytest.fixture
def tries(monkeypatch):
    """Parts in which steps were done again, one number each time."""
    seen, do_again = [], lost.do_again

    def count(rule, model, state, began, who, step, around, parts=1):
        seen.append(parts)
        return do_again(rule, model, state, began, who, step, around, parts)

    monkeypatch.setattr(lost, "do_again", count)
    return seen


def points_of(hair, state):
    return hair.layout.axis(state.positions).reshape(len(hair.groom.ids), -1, 3)


def stretch(points):
    return np.linalg.norm(np.diff(points, axis=1), axis=2).max() / (LENGTH / SEGMENTS)


@pytest.mark.parametrize(("speed", "parts", "held"), [(10.0, 1, False), (100.0, 8, False), (1e4, 8, True)])
def test_a_chain_goes_down_the_ladder_as_far_as_it_must(strands, triangle, tries, speed, parts, held):
    hair, body, shot = strands(3), triangle(), Scene(steps=STEPS)
    good, _ = thrown(hair, body, shot, 0.0, 1)
    assert not tries
    state, reported = thrown(hair, body, shot, speed, 1)
    assert max(tries) == parts
    assert any(UNSOLVED in each for each in reported) == held
    points, others = points_of(hair, state), points_of(hair, good)
    np.testing.assert_array_equal(points[[0, 2]], others[[0, 2]])
    assert np.abs(points[1] - others[1]).max() > 1e-6
    assert stretch(points) < (1.01 if held else 1.2)


def test_a_strand_that_cannot_be_solved_leaves_the_volume_to_the_others(strands, triangle):
    """On the grid its speed would be that of its neighbours: it is held before anything is put there."""
    hair, body = strands(9, apart=2e-3), triangle()
    shot = Scene(steps=STEPS, volume=Volume(friction=60.0))
    good, _ = thrown(hair, body, shot, 0.0, 4)
    state, reported = thrown(hair, body, shot, 1e200, 4)
    assert [each for each in reported if "1 of 9 strands had no solution in 1 of 10 steps" in each]
    points = points_of(hair, state)
    assert stretch(points) < 1.01
    off = np.abs(points - points_of(hair, good)).max(axis=(1, 2))
    assert off[4] < 0.05 * LENGTH and np.delete(off, 4).max() < 0.01 * LENGTH


def test_a_guide_that_cannot_be_solved_keeps_its_lock(strands, triangle):
    """It is named by its own id, its followers go with it, and what is in no lock does not notice."""
    hair, body = strands(4, "network", apart=3e-4), triangle()
    shot = Scene(steps=STEPS, stiction=Stiction(), locks=Locks(after=1, tolerance=0.01, audit=0.0))
    state = None
    for _ in range(4):
        state = next_state(hair, state, Frame((body, body), (), (), 0.0, FRAME), shot)
    leaders = state.leaders(4)
    guide = int(leaders[leaders != np.arange(4)][0])
    good, _ = thrown(hair, body, shot, 0.0, guide, state)
    after, reported = thrown(hair, body, shot, 1e200, guide, state)
    assert [each for each in reported if UNSOLVED in each and f"strands {guide} " in each]
    points = points_of(hair, after)
    assert stretch(points) < 1.02
    assert np.abs(points - points_of(hair, good)).max() < 0.1 * LENGTH
    np.testing.assert_array_equal(after.leaders(4) == guide, good.leaders(4) == guide)
