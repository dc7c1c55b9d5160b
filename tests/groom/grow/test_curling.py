"""A curl is a helix around the strand's axis."""

import numpy as np

from hairpipe.groom.growing import wind

STEP, RADIUS, PITCH, ONSET = 0.0005, 0.006, 0.02, 0.03


def wound(axis, phase=0.3):
    curve = axis.copy()
    wind(curve, STEP, RADIUS, PITCH, ONSET, phase)
    return curve


def straight(direction, count=400):
    return np.arange(count)[:, None] * STEP * np.asarray(direction) / np.linalg.norm(direction)


def test_on_a_straight_axis_it_is_a_helix_in_closed_form():
    for direction in ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.3, -0.5, 0.8)):
        axis = straight(direction)
        off = wound(axis) - axis
        s = np.arange(400) * STEP
        settled = s > ONSET
        assert np.allclose(off @ direction, 0, atol=1e-15)
        assert np.allclose(np.linalg.norm(off[settled], axis=1), RADIUS)
        turn = np.arccos(np.clip(np.sum(off[settled][1:] * off[settled][:-1], axis=1) / RADIUS**2, -1, 1))
        assert np.allclose(turn, 2 * np.pi * STEP / PITCH, atol=1e-6)


def test_it_turns_one_way_by_one_turn_a_pitch():
    axis = straight((0.0, -1.0, 0.0))
    off = wound(axis) - axis
    angle = np.unwrap(np.arctan2(off[1:, 2], off[1:, 0]))
    assert np.isclose(abs(angle[-1] - angle[0]), 2 * np.pi * 398 * STEP / PITCH)


def test_it_grows_out_of_the_root():
    axis = straight((0.0, -1.0, 0.0))
    radius = np.linalg.norm(wound(axis) - axis, axis=1)
    assert radius[0] == 0 and (np.diff(radius) > -1e-15).all()
    assert np.isclose(radius[30], RADIUS / 2), "half way up the smooth step"


def test_the_phase_turns_it_about_the_axis():
    axis = straight((0.0, -1.0, 0.0))
    off, turned = wound(axis, 0.0) - axis, wound(axis, 1.1) - axis
    cosine = np.sum(off * turned, axis=1)[100:] / RADIUS**2
    assert np.allclose(cosine, np.cos(1.1))


def test_around_a_bent_axis_it_stays_at_its_radius_without_twist():
    angle = np.arange(300) * STEP / 0.05
    axis = 0.05 * np.stack([np.cos(angle), np.sin(angle), np.zeros(300)], axis=1)
    off = (wound(axis) - axis)[80:-1]
    outward, upward = axis[80:-1] / 0.05, np.array([0.0, 0.0, 1.0])
    assert np.allclose(np.linalg.norm(off, axis=1), RADIUS)
    around = np.unwrap(np.arctan2(off @ upward, np.sum(off * outward, axis=1)))
    assert np.allclose(np.abs(np.diff(around)), 2 * np.pi * STEP / PITCH, atol=1e-3)
