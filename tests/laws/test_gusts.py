"""Gusts have the statistics that they are asked for, no sources, and are the same again."""

import numpy as np

from hairpipe.laws.gusts import add_gusts, modes_of
from hairpipe.laws.settings import Gusts, Wind
from hairpipe.shot.breeze import Breeze

GUSTS = Gusts(strength=0.8, size=0.3, duration=0.4)
STILL = np.zeros(3)


def velocity(points, seconds=0.0, wind=STILL, gusts=GUSTS):
    air = np.zeros_like(points)
    add_gusts(modes_of(gusts), wind, np.ascontiguousarray(points), seconds, air)
    return air


def places(count=40_000, extent=60.0):
    return np.random.default_rng(5).uniform(-extent, extent, (count, 3))


def test_the_mean_is_none_and_every_component_is_as_strong_as_asked():
    air = velocity(places())
    assert np.abs(air.mean(axis=0)).max() < 0.02
    np.testing.assert_allclose(np.sqrt(np.mean(air**2, axis=0)), 0.8, rtol=0.02)
    covariance = air.T @ air / len(air) / 0.64
    assert np.abs(covariance - np.diag(np.diag(covariance))).max() < 0.03


def test_the_correlation_falls_over_the_size_and_the_duration():
    """Along a line f = exp(-r^2 / 2 l^2), across it g = f + r f' / 2: isotropic, without sources."""
    here, there = places(), np.random.default_rng(6).normal(size=(40_000, 3))
    there /= np.linalg.norm(there, axis=1, keepdims=True)
    first = velocity(here)
    for r in (0.15, 0.3, 0.6):
        second, f = velocity(here + r * there), np.exp(-0.5 * (r / 0.3) ** 2)
        along = np.mean(np.sum(first * there, axis=1) * np.sum(second * there, axis=1)) / 0.64
        both = np.mean(np.sum(first * second, axis=1)) / 0.64
        assert abs(along - f) < 0.05
        assert abs(both - (3.0 - (r / 0.3) ** 2) * f) < 0.12
    for t in (0.2, 0.4, 0.8):
        share = np.mean(first * velocity(here, t)) / 0.64
        assert abs(share - np.exp(-0.5 * (t / 0.4) ** 2)) < 0.05


def test_they_have_no_sources():
    here, step = places(500, 3.0), 1e-5
    parts = [velocity(here + e) - velocity(here - e) for e in step * np.eye(3)]
    gradients = np.stack(parts, axis=2) / (2 * step)
    divergence, size = np.trace(gradients, axis1=1, axis2=2), np.abs(gradients).max()
    assert size > 1.0 and np.abs(divergence).max() < 1e-8 * size


def test_the_wind_carries_them():
    """An eddy that lasts is, a while later, where the wind has taken it."""
    lasting, wind, here = Gusts(0.8, 0.3, 1e4), np.array([2.0, 0.0, -1.0]), places(200, 2.0)
    moved = velocity(here + 1.5 * wind, 1.5, wind, lasting)
    np.testing.assert_allclose(moved, velocity(here, 0.0, wind, lasting), atol=1e-3)


def test_the_fast_cosine_is_a_cosine():
    modes, here = modes_of(GUSTS), places(1000, 2.0)
    phases = here @ modes.waves.T + modes.phases + 0.7 * modes.frequencies
    np.testing.assert_allclose(velocity(here, 0.7), np.cos(2 * np.pi * phases) @ modes.amplitudes, atol=1e-9)


def test_a_place_and_a_time_have_one_wind_whoever_asks():
    here, offsets = places(3000, 1.0), np.array([0, 3000], np.int32)
    breeze = Breeze(Wind((1.0, 0.0, 0.0), gusts=GUSTS), 8e-5, offsets)
    whole = breeze.air(here, 12.25)
    some = Breeze(Wind((1.0, 0.0, 0.0), gusts=GUSTS), 8e-5, np.array([0, 200], np.int32))
    part = some.air(here[700:900], 12.25)
    np.testing.assert_array_equal(whole[700:900], part)
    assert np.abs(velocity(here) - velocity(here, gusts=Gusts(0.8, 0.3, 0.4, seed=1))).max() > 0.5
