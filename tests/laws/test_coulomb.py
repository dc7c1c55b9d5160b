"""Coulomb's law, in each form in which solvers call it: within mu N, against the motion, equal to the secant."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hairpipe.laws.coulomb import coulomb, elongated, impulse, slide

numbers = st.floats(-10.0, 10.0, allow_subnormal=False)
vectors = st.tuples(numbers, numbers, numbers)
positive = st.floats(1e-6, 1e3)
quick = settings(max_examples=200, deadline=None)


def across(u, n):
    return np.array(u) - np.dot(u, n) * np.array(n)


def unit(n):
    size = np.linalg.norm(n)
    return tuple(np.array(n) / size) if size > 1e-3 else (0.0, 1.0, 0.0)


@given(positive, positive, st.floats(0.0, 1e3))
@quick
def test_the_force_is_within_the_limit_and_equal_to_it_where_hair_slides(most, limit, moved):
    c = coulomb(most, limit, moved)
    assert 0.0 < c <= most
    assert c * moved <= limit * (1.0 + 1e-15)
    if most * moved > limit * (1.0 + 1e-12):
        assert c * moved == pytest.approx(limit, rel=1e-14)
    if most * moved < limit * (1.0 - 1e-12):
        assert c == most


def test_hair_at_rest_sticks_and_hair_without_load_slides_freely():
    assert coulomb(3.0, 0.0, 0.0) == 3.0
    assert coulomb(3.0, 0.0, 1.0) == 0.0


@given(vectors, vectors, st.floats(0.0, 5.0), st.floats(0.0, 2.0))
@quick
def test_a_push_slows_sliding_by_mu_of_it_and_turns_nothing_around(u, n, push, friction):
    n = unit(n)
    v = np.array(slide(u, n, push, friction))
    before, after = across(u, n), across(v, n)
    assert np.dot(v, n) == pytest.approx(np.dot(u, n) + push, abs=1e-12)
    lost = np.linalg.norm(before) - np.linalg.norm(after)
    assert lost == pytest.approx(min(friction * push, np.linalg.norm(before)), abs=1e-11)
    assert np.dot(before, after) >= -1e-11


@given(vectors, vectors, st.floats(1e-3, 5.0), st.floats(0.0, 2.0), st.floats(1e-8, 1e-3))
@quick
def test_the_impulse_of_an_impact_is_in_the_cone_and_is_the_slide_times_the_mass(u, n, dv, friction, mass):
    n = unit(n)
    p = np.array(impulse(u, n, dv, friction, mass))
    normal = np.dot(p, n)
    assert normal == pytest.approx(mass * dv, rel=1e-12)
    assert np.linalg.norm(across(p, n)) <= friction * normal * (1.0 + 1e-9) + 1e-14 * normal
    assert np.allclose(p, mass * (np.array(slide(u, n, dv, friction)) - np.array(u)), atol=1e-12 * mass)


@given(vectors, vectors, st.floats(1e-6, 1e-2), positive, st.floats(1e-4, 1e-2), positive)
@quick
def test_the_spring_of_two_hairs_pulls_back_within_the_limit(s, u, h, stiffness, relaxation, limit):
    s = tuple(1e-3 * np.array(s))
    c, e = elongated(s, u, u, h, stiffness, relaxation, limit, 0.0)
    ahead = np.linalg.norm(np.array(s) + relaxation * np.array(u))
    assert np.allclose(e, np.array(s) + relaxation * np.array(u))
    assert c * ahead <= limit * (1.0 + 1e-12)
    assert c == pytest.approx(min(stiffness, limit / max(ahead, 1e-12)), rel=1e-12)


def test_hair_without_load_has_no_friction_where_an_impact_takes_more_than_moves():
    c, _ = elongated((1e-6, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1e-3, 1e3, 5e-3, 0.0, 1e-3)
    assert c == 0.0


def test_steady_sliding_of_hair_has_the_friction_mu_n_at_any_speed():
    """Without an elongation yet, or with one that keeps up: the force is the limit once k r |u| is beyond it."""
    for speed in (0.01, 0.1, 1.0, 10.0):
        c, e = elongated((0.0, 0.0, 0.0), (speed, 0.0, 0.0), (speed, 0.0, 0.0), 1e-3, 1e3, 5e-3, 1e-2, 0.0)
        assert c * np.linalg.norm(e) == pytest.approx(1e-2, rel=1e-12)


def test_an_impact_slows_two_free_hairs_by_the_impulse_of_the_law():
    """An implicit step of a contact that carried nothing takes t mu N / m from the sliding, however long the step."""
    friction_force, mass, relaxation = 2e-3, 1e-6, 5e-3
    for h in (1e-4, 1e-3, 4e-3):
        u = 50.0
        slowed = h * (h + relaxation) * friction_force / mass
        c, e = elongated((0.0, 0.0, 0.0), (u, 0.0, 0.0), (u, 0.0, 0.0), h, 1e6, relaxation, friction_force, slowed)
        stiffness_of_stage = h * (h + relaxation) * c
        change = -h * c * e[0] / (mass + stiffness_of_stage)
        assert change == pytest.approx(-h * friction_force / mass, rel=1e-9)
