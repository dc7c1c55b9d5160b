"""Ends of strands: at their keys when they should be, with rates that are the derivatives of their places."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, Wave, course_of, drive, instant_of
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.node.settings import check_settings
from hairpipe.errors import BadInput
from hairpipe.groom.strands import lay_strands
from hairpipe.values import Ends

GROOM = lay_strands(2, 0.3, 10, (1.0, 0.2, 0.0), (0.0, 0.0, 0.01), None, 0.0)
ROOT, TIP = GROOM.points[0], GROOM.points[10]
MOVE = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.2), (0.1, -0.3, 0.2))
TURNED = Track((0.5, 1.0, 2.0), MOVE, (0.0, 90.0, -30.0), (1.0, 2.0, 0.5), (0.05, 0.1, -0.02))
SHAKE = Wave("sine", 2.0, 0.0, (1.0, 0.0, 0.0), 600.0, (0.0, 1.0, 0.0), (-0.1, 0.0, 0.0))
SQUARE = Wave("square", 4.0, 2.0, (0.0, 0.0, 3.0), 360.0, (1.0, 0.0, 0.0))


def ends(time, roots=None, wave=None, tips=None, release=None) -> Ends:
    return drive(GROOM, time, roots or Track(), wave, tips, release)


def moved(place: np.ndarray, point: np.ndarray, strand: int = 0) -> np.ndarray:
    return place[strand, :, :3] @ point + place[strand, :, 3]


@pytest.mark.parametrize("ease", ["smooth", "linear"])
@pytest.mark.parametrize("wave", [None, SHAKE, SQUARE])
def test_rates_are_the_derivatives(ease, wave):
    track, step = replace(TURNED, ease=ease), 1e-6
    for time in (0.2, 0.61, 0.99, 1.3, 1.77, 2.4):
        found = ends(time, track, wave, track)
        before, after = (ends(time + shift, track, wave, track) for shift in (-step, step))
        for name in ("roots", "tips"):
            difference = (getattr(after, name) - getattr(before, name)) / (2 * step)
            np.testing.assert_allclose(getattr(found, name + "_rate"), difference, atol=2e-7)


@pytest.mark.parametrize("ease", ["smooth", "linear"])
def test_keys_are_hit_and_held(ease):
    track = Track((0.5, 1.0, 2.0), MOVE, ease=ease)
    for time, move in ((0.0, MOVE[0]), (0.5, MOVE[0]), (1.0, MOVE[1]), (2.0, MOVE[2]), (9.0, MOVE[2])):
        found = ends(time, track, tips=track)
        np.testing.assert_allclose(moved(found.roots, ROOT), ROOT + move, atol=1e-15)
        np.testing.assert_allclose(moved(found.tips, TIP), TIP + move, atol=1e-15)
    assert not ends(0.4, track).roots_rate.any() and not ends(2.1, track).roots_rate.any()


def test_linear_is_of_constant_speed_and_halves_it_where_it_begins():
    track = Track((0.0, 1.0), ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0)), ease="linear")
    speeds = [ends(time, track).roots_rate[0, 0, 3] for time in (-0.1, 0.0, 0.3, 0.9, 1.0, 1.1)]
    np.testing.assert_allclose(speeds, [0.0, 0.2, 0.4, 0.4, 0.2, 0.0])
    np.testing.assert_allclose(moved(ends(0.3, track).roots, ROOT), ROOT + np.array([0.12, 0.0, 0.0]))


def test_a_turn_is_right_handed_about_an_axis_through_its_pivot():
    track = Track((0.0,), turn=(90.0,), axis=(0.0, 0.0, 2.0), pivot=(0.0, 0.1, 0.0))
    found = ends(0.0, track).roots
    for strand, root in enumerate(GROOM.points[GROOM.offsets[:-1]]):
        np.testing.assert_allclose(moved(found, root, strand), root + np.array([0.1, 0.1, 0.0]), atol=1e-15)
        np.testing.assert_allclose(
            moved(found, root + np.array([0.0, 0.1, 0.0]), strand), root + np.array([0.0, 0.1, 0.0]), atol=1e-15
        )


def test_every_motion_is_rigid():
    for time in (0.3, 0.8, 1.1):
        turn = ends(time, TURNED, SHAKE).roots[:, :, :3]
        np.testing.assert_allclose(turn @ turn.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (2, 3, 3)), atol=1e-14)


def test_a_shake_is_as_fast_as_it_says():
    found = ends(0.125, wave=SHAKE)
    rate = found.roots_rate[0, :, :3] @ found.roots[0, :, :3].T
    np.testing.assert_allclose(rate[0, 2], np.radians(600.0), rtol=1e-12)
    arm = moved(found.roots, ROOT) - (ROOT + np.array([-0.1, 0.0, 0.0]))
    np.testing.assert_allclose(np.linalg.norm(arm), 0.1)
    assert not ends(0.0, wave=SHAKE).roots_rate.any() and not ends(-0.1, wave=SHAKE).roots_rate.any()


def test_a_wave_turns_about_the_end_wherever_the_keys_have_it():
    for time in (0.25, 0.6, 1.4):
        led, shaken = ends(time, TURNED), ends(time, TURNED, replace(SHAKE, pivot=(0.0, 0.0, 0.0)))
        assert np.abs(led.roots - shaken.roots).max() > 0.01
        np.testing.assert_allclose(moved(shaken.roots, ROOT), moved(led.roots, ROOT), atol=1e-12)
        np.testing.assert_allclose(moved(shaken.roots_rate, ROOT), moved(led.roots_rate, ROOT), atol=1e-12)


def test_a_square_wave_turns_round_at_once():
    rates = {time: ends(time, wave=SQUARE).roots_rate[0] for time in (0.01, 0.12, 0.13, 0.24, 0.26)}
    for time, sign in ((0.01, 1), (0.12, 1), (0.13, -1), (0.24, -1), (0.26, 1)):
        centre = rates[time][:, :3] @ ROOT + rates[time][:, 3]
        np.testing.assert_allclose(centre, [0.0, 0.0, 2.0 * sign], atol=1e-12)
    np.testing.assert_allclose(
        moved(ends(0.125, wave=SQUARE).roots, ROOT), ROOT + np.array([0.0, 0.0, 0.25]), atol=1e-12
    )
    for time in (0.0, 0.125, 0.25, 3 / 24, 30 / 24):
        assert not ends(time, wave=SQUARE).roots_rate.any()


def test_tips_are_held_until_they_are_released():
    assert np.isnan(ends(0.0).tips).all() and np.isnan(ends(0.0).tips_rate).all()
    for time, is_free in ((0.0, False), (48 / 24, False), (49 / 24, True)):
        assert np.isnan(ends(time, tips=Track(), release=2.0).tips).all() == is_free
    np.testing.assert_array_equal(ends(5.0, tips=Track()).tips[1], np.eye(3, 4))


def test_keys_that_do_not_belong_together_are_refused():
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"times": (1.0, 1.0)}, "ascending"),
        ({"times": (1.0, 0.5)}, "ascending"),
        ({"times": (0.0, 1.0), "move": MOVE}, "move has 3 keys, times has 2"),
        ({"turn": (30.0,)}, "turn has 1 keys, times has 0"),
        ({"axis": (0.0, 0.0, 0.0)}, "axis = .* has no length"),
    ]
    for keys, reported in wrong:
        with pytest.raises(BadInput, match=reported):
            Track(**keys)
    for name in ("along", "axis"):
        with pytest.raises(BadInput, match=f"{name} = .* has no length"):
            replace(Wave(), **{name: (0.0, 0.0, 0.0)})


@pytest.mark.parametrize("group", ["roots", "wave", "tips"])
def test_the_group_of_an_axis_without_length_is_named(group):
    with pytest.raises(BadInput, match=rf"here: {group}: axis = \[0.0, 0.0, 0.0\] has no length"):
        check_settings(Registry().find("drive_ends"), {group: {"axis": [0.0, 0.0, 0.0]}}, lambda names: "here")


@pytest.mark.parametrize(("frame", "speed"), [(11, 1.0), (12, 13.0), (13, 13.0), (14, 1.0)])
def test_at_a_cut_a_track_has_the_speed_of_one_side(frame, speed):
    """It goes at 1 m/s, but for a metre between the frames 12 and 13."""
    times = (0.0, 11 / 24, 12 / 24, 1.0)
    track = Track(times, tuple((time + (time > 0.47), 0.0, 0.0) for time in times), ease="linear")
    plain, cut = (course_of(track, instant_of(frame, 1, 24.0, cuts)) for cuts in ((), (13,)))
    assert (plain.shift_rate[0], cut.shift_rate[0]) == pytest.approx((speed, 1.0))
    assert cut.shift == pytest.approx(plain.shift, abs=1e-8)
