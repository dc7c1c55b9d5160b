"""Curls and the heights at which a body holds them."""

import numpy as np
import pytest

from hairpipe.laws.fold_preservation import add_heights, set_centres, turns_of


def helix(radius, pitch, segment, count, phase=0.0):
    """Points of a helix about x at equal chords."""
    arc = np.hypot(2 * np.pi * radius, pitch)
    angle = 2 * np.pi * segment / arc * np.arange(count) + phase
    return np.stack([pitch * angle / (2 * np.pi), radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def offsets_of(*strands):
    return np.concatenate([[0], np.cumsum([len(s) for s in strands])]).astype(np.int32)


@pytest.mark.parametrize("turn", [8, 12, 20])
def test_the_points_of_a_turn_and_its_radius_are_found(turn):
    radius, pitch = 0.008, 0.012
    coil = helix(radius, pitch, np.hypot(2 * np.pi * radius, pitch) / turn, 5 * turn)
    straight = np.linspace(0, 0.2, 40)[:, None] * np.array([0.3, 0.9, 0.1])
    wave = straight + 1e-4 * np.random.default_rng(1).normal(size=straight.shape)
    turns = turns_of(np.concatenate([coil, straight, wave]), offsets_of(coil, straight, wave))
    assert turns.points.tolist()[:2] == [turn, 1]
    np.testing.assert_allclose(turns.radii[0], radius, rtol=0.1)
    assert turns.radii[1] == 0.0


def test_centres_lie_on_the_axis():
    coil = helix(0.01, 0.01, 0.005, 66)
    offsets = offsets_of(coil)
    turns = turns_of(coil, offsets)
    centres = np.empty_like(coil)
    set_centres(coil, offsets, turns.points, centres)
    assert np.abs(centres[:, 1:]).max() < 0.06 * 0.01


def test_heights_put_the_side_of_the_tube_at_the_thickness():
    """Over a plate below the helix, what a point keeps minus its height over the lowest point is the same for all."""
    radius = 0.01
    coil = helix(radius, 0.01, np.hypot(2 * np.pi * radius, 0.01) / 16, 80)
    offsets = offsets_of(coil)
    up = np.tile([0.0, 1.0, 0.0], (80, 1))
    thickness = np.full(80, 1e-3)
    add_heights(coil, offsets, turns_of(coil, offsets), up, 1.0, thickness)
    inner = slice(8, -8)
    np.testing.assert_allclose((thickness - coil[:, 1])[inner], 1e-3 + radius, atol=0.05 * radius)
    assert thickness[0] == 1e-3  # the root is held
    kept = np.full(80, 1e-3)
    add_heights(coil, offsets, turns_of(coil, offsets), np.zeros((80, 3)), 1.0, kept)
    np.testing.assert_array_equal(kept, 1e-3)


def test_radii_are_those_of_each_strand_and_a_kink_has_none():
    wide, narrow = (helix(radius, 0.01, np.hypot(2 * np.pi * radius, 0.01) / 16, 80) for radius in (0.01, 0.004))
    kink = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [2, 2, 0], [2, 3, 0]]) * 0.01
    turns = turns_of(np.concatenate([wide, kink, narrow]), offsets_of(wide, kink, narrow))
    assert turns.points.tolist() == [16, 1, 16] and turns.radii[1] == 0.0
    np.testing.assert_allclose(turns.radii[[0, 2]], [0.01, 0.004], rtol=0.1)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_heights_turn_with_the_scene(axis):
    coil = helix(0.01, 0.01, np.hypot(2 * np.pi * 0.01, 0.01) / 16, 80)
    up = np.tile([0.0, 1.0, 0.0], (80, 1))
    expected, turned = np.zeros(80), np.zeros(80)
    offsets = offsets_of(coil)
    add_heights(coil, offsets, turns_of(coil, offsets), up, 1.0, expected)
    coil, up = (np.ascontiguousarray(np.roll(a, axis - 1, axis=1)) for a in (coil, up))
    add_heights(coil, offsets, turns_of(coil, offsets), up, 1.0, turned)
    np.testing.assert_allclose(turned, expected, atol=1e-12)
