"""Rods in motion: what a step keeps, and what it does where it is beyond the scheme."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.errors import BadInput
from hairpipe.geometry.curl import Helix, wound
from hairpipe.geometry.frames import TWIST
from hairpipe.laws.settings import Air, Collisions, Drag, Scheme, StepControl, Stiction
from hairpipe.shot.settings import Scene
from hairpipe.shot.shot import Frame, move_over_cut
from hairpipe.shot.simulate import advance_frame, next_state, start, warn_of_lost
from hairpipe.solve import surroundings
from hairpipe.solve.implicit_stage import factor_stages, find_overturned
from hairpipe.solve.sag_free import find_stable_by_pivots
from hairpipe.strands.hair_model import Precision, build_hair
from hairpipe.strands.material import Material
from hairpipe.values import Ends, Mesh

FRAME = 1 / 24
STEPS = StepControl(longest=1 / 240, travel=10.0, root=10.0)


def curl(turn=0.0):
    """A curl of three turns, 30 cm long, that sticks out at an angle."""
    return wound(Helix(0.015, 0.03), 0.3, 25) @ Rotation.from_euler("xz", [1.0, turn]).as_matrix().T


@pytest.fixture
def rods(scene):
    def build(*strands, precision: Precision = "double"):
        return build_hair(scene(strands).hair.groom, Material(), "rod", precision=precision)

    return build


def run(hair, state, body, scene, frames):
    for _ in range(frames):
        state = advance_frame(hair, state, (body, body), (), FRAME, scene)
    return state


def test_a_curl_let_go_of_is_not_lost_and_its_edges_keep_their_lengths(rods, triangle):
    hair, scene = rods(curl(), curl(2.0)), Scene(steps=STEPS)
    state = run(hair, start(hair, triangle(), scene), triangle(), scene, 24)
    lengths = np.linalg.norm(np.diff(state.positions[2:-1], axis=0), axis=1) * hair.model.inverse_lengths[2:-2, 0]
    assert np.abs(lengths - 1).max() < 0.005
    assert not state.tensions[hair.model.first[:-1], 1].any()


def test_one_solve_a_stage_is_as_good_as_many(rods, triangle):
    """Where a solve is linearised, twists are predicted as well as positions: a second iteration changes little."""
    hair, ends = rods(curl(), curl(1.0), curl(2.0)), []
    for step, iterations in ((1 / 240, 1), (1 / 240, 4), (1 / 960, 4)):
        steps = replace(STEPS, longest=step)
        scene = Scene(air=Air(Drag(0.1)), steps=steps, scheme=Scheme(iterations=iterations))
        state = run(hair, start(hair, triangle(), scene), triangle(), scene, 12)
        ends.append(hair.layout.axis(state.positions))
    assert np.abs(ends[0] - ends[1]).max() < 0.2 * np.abs(ends[1] - ends[2]).max()


def fold(hair, state, way):
    """Fold the tip of the first rod over by 150 degrees, to half its length."""
    before, node, tip = (state.positions[row, :, 0] for row in (-4, -3, -2))
    across = np.cross(node - before, way)
    edge = -np.cos(0.5) * (node - before) / 2 + np.sin(0.5) * across / np.linalg.norm(across) * 0.006
    state.positions[-2:, :, 0] += node + edge - tip


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.5), (-0.5, 0.3, -1.0)])
def test_a_rod_whose_tip_contact_has_folded_over_comes_back(rods, triangle, way):
    """What is left of the stiffness then holds no angle by itself; no edge is stretched so that a step is repeated."""
    hair, scene = rods(curl()), Scene(gravity=0.0, steps=STEPS)
    state = start(hair, triangle(), scene)
    fold(hair, state, way)
    stable = np.ones((len(hair.model.first) - 1, state.positions.shape[-1]))
    find_stable_by_pivots(hair.model, state.positions, state.tensions, stable)
    assert stable[0, 0] == 0.0
    state = advance_frame(hair, state, (triangle(), triangle()), (), FRAME, scene)
    lengths = np.linalg.norm(np.diff(state.positions[2:-1], axis=0), axis=1) * hair.model.inverse_lengths[2:-2, 0]
    assert not state.tensions[hair.model.first[:-1], 1].any()
    assert np.abs(lengths - 1).max() < 0.05 and np.abs(state.velocities).max() < 20.0


def bent(bends, turn):
    """A strand of 27 cm whose vertices bend by angles [rad], in one plane, turned about its first segment [rad]."""
    across = np.array([np.sin(turn), 0.0, -np.cos(turn)])
    ways = Rotation.from_rotvec(np.cumsum([0.0, *bends])[:, None] * across).apply([0.0, 1.0, 0.0])
    return np.cumsum(0.27 / len(ways) * np.insert(ways, 0, 0.0, axis=0), axis=0)


@pytest.mark.parametrize("now", [20, 29])
def test_a_bend_out_of_the_natural_plane_turns_the_frame_no_further_than_into_it(rods, triangle, now):
    """Its torque vanishes there, but one linear solve would turn the tip by revolutions."""
    turn = np.deg2rad(100)
    natural, posed = bent(np.deg2rad([5] * 15), 0.0), bent(np.deg2rad([0] * 11 + [now] * 4), turn)
    hair, scene = rods(natural), Scene(gravity=0.0, steps=replace(STEPS, longest=1 / 96))
    state = start(hair, triangle(), scene)
    moved = np.concatenate([posed - natural, (posed - natural)[-1:]])[:, :, None]
    state.positions[2:] += moved
    after = advance_frame(hair, state, (triangle(), triangle()), (), 1 / 96, scene)
    twist = np.abs(np.cumsum(after.tensions[2:-2, TWIST, 0]))
    assert 0.1 < twist.max() < turn


def test_a_turned_scene_is_the_same_scene(rods, straight, triangle):
    """About the vertical; the groom's own frame of the root turns with it."""
    turn, scene = Rotation.from_euler("y", 0.7).as_matrix(), Scene(steps=STEPS)
    hair = rods(curl())
    turned = build_hair(
        replace(
            hair.groom,
            points=hair.groom.points @ turn.T,
            root_frames=np.einsum("ij,sjk->sik", turn, hair.groom.root_frames),
        ),
        Material(),
        "rod",
    )
    ends = [run(each, start(each, None, scene), None, scene, 8).positions[2:-1, :, 0] for each in (hair, turned)]
    np.testing.assert_allclose(ends[0] @ turn.T, ends[1], atol=1e-9)


def twisting(groom, turn, rate):
    """Roots that stand, and tips that turn about the vertical through them."""
    still = np.repeat(np.eye(3, 4)[None], 1, axis=0)
    tips, rates = still.copy(), np.zeros_like(still)
    point, R = groom.points[-1], Rotation.from_rotvec([0.0, turn, 0.0]).as_matrix()
    spin = rate * np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]) @ R
    tips[0, :, :3], tips[0, :, 3], rates[0, :, :3], rates[0, :, 3] = R, point - R @ point, spin, -spin @ point
    return Ends(still, np.zeros_like(still), tips, rates)


def test_a_held_tip_that_turns_twists_a_straight_rod_evenly(rods, straight):
    """By 2 rad: the root's vertex has half a length, and the torque is the same everywhere."""
    hair, scene, twist, frames = rods(straight(0.1, 25, [0, 1, 0])), Scene(0.0, steps=STEPS), 2.0, 12
    state = start(hair, twisting(hair.groom, 0.0, 0.0), scene)
    for i in range(frames):
        now, then = (
            twisting(hair.groom, twist * k / frames, twist / frames / FRAME * (k < frames)) for k in (i, i + 1)
        )
        state = advance_frame(hair, state, (now, then), (), FRAME, scene)
    torque = (state.tensions[:, TWIST] * hair.model.inverse_lengths[:, 5])[2:-2, 0]
    np.testing.assert_allclose(torque, Material().torsion * twist / (0.1 * 24.5 / 25), rtol=1e-9)
    np.testing.assert_allclose(state.positions[2:-1], hair.rest[2:-1], atol=1e-12)


def test_a_cut_carries_a_rod_with_its_root(rods, triangle):
    """Its shape relative to the root, and so its twists and forces, are those before the cut."""
    hair, scene, turn = rods(curl()), Scene(steps=STEPS), Rotation.from_euler("xyz", [0.4, 1.0, 2.0]).as_matrix()
    before, body = start(hair, triangle(), scene), triangle()
    before = run(hair, before, body, scene, 4)
    after = Mesh(body.points @ turn.T, body.triangles)
    carried = move_over_cut(hair, before, (body, after))
    assert carried.tensions is before.tensions
    np.testing.assert_allclose(carried.positions[:, :, 0], before.positions[:, :, 0] @ turn.T, atol=1e-9)


def test_single_precision_follows_double(rods, triangle):
    scene = Scene(steps=STEPS)
    hair, single = rods(curl()), rods(curl(), precision="single")
    ends = [run(each, start(each, triangle(), scene), triangle(), scene, 12) for each in (hair, single)]
    tips = [each.layout.axis(end.positions)[-1] for each, end in zip((hair, single), ends, strict=True)]
    assert np.linalg.norm(tips[0] - tips[1]) < 1e-3 * 0.3


@pytest.mark.parametrize(("scheme", "drag"), [("tr_bdf2", 0.1), ("bdf2", 0.1), ("backward_euler", 8.0)])
def test_rods_lost_in_long_steps_are_solved_again_with_a_warning(rods, triangle, scheme, drag):
    steps = StepControl(longest=FRAME, travel=100.0, root=100.0)
    hair = rods(curl(), curl(1.0), curl(2.0), curl(3.0))
    scene = Scene(air=Air(Drag(drag)), steps=steps, scheme=Scheme(scheme))
    body, state, reported = triangle(), None, []
    for number in range(36):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            state = next_state(hair, state, Frame((body, body), (), (), number * FRAME, FRAME), scene)
        reported += [str(each.message) for each in caught]
    assert state is not None and np.isfinite(state.positions).all()
    again = state.tensions[hair.model.first[:-1], 1]
    assert any("were re-solved with backward Euler" in each for each in reported) == bool(again.any())
    assert 0 < again.sum() < 0.2 * 36 * again.size


def test_few_of_many_strands_may_repeat_a_step_without_a_warning(rods, triangle):
    hair = rods(*(curl() for _ in range(200)))
    before = start(hair, triangle(), Scene(steps=STEPS))
    root = hair.model.first[:-1]
    for count, warned in ((2, False), (3, True), (3, True)):
        after = replace(before, tensions=before.tensions.copy())
        after.tensions[root[0], 1, :count] += 1.0
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            warn_of_lost(hair, before, after, 1001)
        assert [f"{count} strands were re-solved" in str(each.message) for each in caught] == [True] * warned
        before = after


def test_rods_touch_and_any_number_of_threads_gives_the_same_bytes(rods, straight, triangle, same_on_threads):
    ways = [(1.0, 0.2 * np.sin(i), 0.3 * np.cos(i)) for i in range(9)]
    strands = [straight(0.08, 10, way) + np.array([0, 4e-4, 2e-4]) * i for i, way in enumerate(ways)]
    scene = Scene(steps=STEPS, collisions=Collisions(), stiction=Stiction())
    hair = rods(*strands)
    state = same_on_threads(lambda: run(hair, start(hair, triangle(), scene), triangle(), scene, 4))
    assert len(state.stuck) > 0


def test_neighbours_of_a_rod_that_turned_too_far_are_solved_again(rods, straight, triangle, monkeypatch):
    hair, scene, firm = rods(straight(0.08, 10, (1, 0, 0))), Scene(steps=STEPS, collisions=Collisions()), []

    def find(model, b, active, weights):
        active[:] *= 2.0
        return 1

    def factor(*given):
        firm.append(given[4].max() == 2.0)
        return factor_stages(*given)

    monkeypatch.setattr(surroundings, "factor_stages", factor)
    run(hair, start(hair, triangle(), scene), triangle(), scene, 1)
    assert firm and not any(firm)
    once = len(firm)
    firm.clear()
    monkeypatch.setattr(surroundings, "find_overturned", find)
    run(hair, start(hair, triangle(), scene), triangle(), scene, 1)
    assert firm == [False, True] * once


def test_a_turn_beyond_half_a_radian_is_marked_where_it_was_solved(rods):
    hair = rods(curl(), curl(1.0), curl(2.0))
    b = np.zeros((len(hair.rest), 4, hair.rest.shape[-1]))
    weights, active = np.ones((1, b.shape[2])), np.ones((1, b.shape[2]))
    b[7, 3, :3] = np.array([0.51, -0.49, -0.51]) / hair.model.scale[0, 0, :3]
    active[0, 2:] = 0.0
    assert find_overturned(hair.model, b, active, weights) == 1
    assert active[0].tolist() == [2.0, 1.0, *[0.0] * (b.shape[2] - 2)]
    assert find_overturned(hair.model, b, active, weights) == 0  # it had the projected stiffness


@pytest.mark.parametrize("scheme", [Scheme("nine_steps"), Scheme("backward_euler", spring="printed")])
def test_schemes_that_leave_out_stiffness_are_refused(rods, straight, triangle, scheme):
    with pytest.raises(BadInput, match=r"not for a rod|a rod needs") as refused:
        start(rods(straight(0.1, 5, [0, -1, 0])), triangle(), Scene(scheme=scheme))
    assert "tr_bdf2" in str(refused.value.right) or "multiplier" in str(refused.value.right)
