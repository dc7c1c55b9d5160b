"""A cut leaves the shape of the hair and its motion against the root as they were."""

from dataclasses import replace

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.shot.shot import move_over_cut
from hairpipe.shot.simulate import restored, start
from hairpipe.values import Ends
from hairpipe.values.hair import Touching


@pytest.fixture
def swinging(scene, straight):
    """Hair of two kinds in mid-swing, on a body at rest."""
    return scene([straight(0.1, 10, [1, 0.2, 0]), straight(0.08, 7, [0.3, -1, 0.5])]).run(0.25)


def touch(*points: int) -> Touching:
    """Contact of points with a body."""
    count = len(points)
    damping, normals = np.arange(2.0 * count).reshape(-1, 2), np.tile([0.0, 1.0, 0.0], (count, 1))
    slid = 0.1 * normals
    return Touching(np.array(points, np.int32), np.full(count, 2, np.int8), damping, slid, normals)


def in_root_frame(hair, state, ends: Ends):
    """Positions, velocities and accelerations of the axis against the roots, and in their frames."""
    strands = np.repeat(np.arange(2), np.diff(hair.layout.offsets))
    x, v, a = (hair.layout.axis(values) for values in (state.positions, state.velocities, state.accelerations))
    (turn, rate), (place, speed) = ((m[strands] for m in parts) for parts in _split(ends))
    own = np.einsum("pji,pj->pi", turn, x - place)
    against = v - speed - np.einsum("pij,pj->pi", rate, own)
    return own, np.einsum("pji,pj->pi", turn, against), np.einsum("pji,pj->pi", turn, a)


def _split(ends: Ends):
    both = (ends.roots, ends.roots_rate)
    return [m[:, :, :3] for m in both], [m[:, :, 3] for m in both]


def test_shape_and_motion_against_the_root_are_the_same_on_both_sides(swinging):
    hair = swinging.hair
    state = replace(swinging.state, touching=touch(5, 14))
    turned = Track((0.0, 1.0), ((0.0, 0.0, 0.0), (5.0, -2.0, 9.0)), (0.0, 250.0), (1.0, 2.0, 0.5), (0.1, 0.0, 0.3))
    before, after = drive(hair.groom, 0.3, turned, None, None, None), drive(hair.groom, 0.8, turned, None, None, None)
    carried = move_over_cut(hair, state, (before, after))
    old, new = in_root_frame(hair, state, before), in_root_frame(hair, carried, after)
    assert np.abs(carried.positions - state.positions).max() > 1.0
    for one, other, scale in zip(old, new, (1.0, 10.0, 1000.0), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-13 * scale)
    assert carried.tensions is state.tensions and carried.inverse_lengths is state.inverse_lengths
    assert carried.touching is None  # the body has moved apart from hair


def test_no_cut_changes_nothing(swinging, triangle):
    hair, state = swinging.hair, swinging.state
    body = triangle(velocities=np.random.default_rng(1).normal(size=(3, 3)))
    carried = move_over_cut(hair, state, (body, body))
    np.testing.assert_allclose(carried.positions, state.positions, atol=1e-14)
    np.testing.assert_allclose(carried.velocities, state.velocities, atol=1e-12)
    np.testing.assert_allclose(carried.accelerations, state.accelerations, atol=1e-10)


def test_no_whip_after_a_leap_and_a_turn_about_the_plumb_line(swinging, triangle):
    """Hair that is carried across goes on as it would have, there."""
    hair, state = swinging.hair, swinging.state
    turn, shift = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]), np.array([3.0, 2.0, -4.0])
    there = triangle(triangle().points @ turn.T + shift)
    here = swinging.run(0.25).axis
    swinging.state, swinging.body = move_over_cut(hair, state, (triangle(), there)), there
    np.testing.assert_allclose(swinging.run(0.25).axis, here @ turn.T + shift, atol=1e-9)


def test_hair_that_starts_moves_with_the_body_after_the_cut(swinging, triangle):
    hair = swinging.hair
    moving = triangle(triangle().points + 2.0, np.tile([1.0, 0.0, -3.0], (3, 1)))
    first = start(hair, triangle(), swinging.scene)
    carried, begun = move_over_cut(hair, first, (triangle(), moving)), start(hair, moving, swinging.scene)
    np.testing.assert_allclose(carried.positions, begun.positions, atol=1e-14)
    np.testing.assert_allclose(carried.velocities, begun.velocities, atol=1e-9)


def test_a_strand_that_is_reset_touches_nothing_and_the_others_what_they_did(swinging, triangle):
    hair, state = swinging.hair, swinging.state
    lost = replace(state, positions=state.positions.copy(), touching=touch(5, 14))  # one on each strand
    first = hair.layout.strands[0, 0]
    lost.positions[hair.layout.first[0] + 5, :, 0] = np.nan
    mended, reset = restored(hair, lost, triangle())
    assert set(hair.layout.strands[reset]) == {first} and np.isfinite(mended.positions).all()
    [kept] = (
        k for k, point in enumerate((5, 14)) if not hair.layout.offsets[first] <= point < hair.layout.offsets[first + 1]
    )
    np.testing.assert_array_equal(mended.touching.points, lost.touching.points[[kept]])
    np.testing.assert_array_equal(mended.touching.damping, lost.touching.damping[[kept]])
