"""Couplings as kernels against the same as one dense matrix."""

import numba
import numpy as np

from hairpipe.solve.couplings import (
    Couplings,
    coupling_rows,
    find_incidence,
    follow,
    impulses_after,
    join,
    multiply_across,
    part_of,
)

from ..coupled_strands import OFFSETS, own_matrix, random_couplings, whole_matrix

SINGLE = 1e-6
"""Other sides are multiplied in single precision."""


def sorted_sides(couplings, points):
    return coupling_rows(couplings, find_incidence(couplings.segments, points))


def multiply(couplings, points, v):
    v = v.astype(np.float32)
    out = np.empty_like(v)
    multiply_across(sorted_sides(couplings, points), v, np.zeros_like(v), out)
    return out


def blocks(couplings, points):
    sides = sorted_sides(couplings, points)
    return sides.diagonal, sides.following


def test_own_and_across_are_together_the_whole_matrix():
    offsets = np.array([0, 2, 7, 16, 19], np.int32)
    points = int(offsets[-1])
    couplings = random_couplings(offsets, 60)
    whole = whole_matrix(couplings, points)
    across = np.stack([multiply(couplings, points, e.reshape(-1, 3)).ravel() for e in np.eye(3 * points)], axis=1)
    sum_of_both = own_matrix(*blocks(couplings, points)) + across
    np.testing.assert_allclose(sum_of_both, whole, atol=SINGLE * np.abs(whole).max())


def test_pushes_reach_points_by_their_weights_and_are_opposite():
    points = int(OFFSETS[-1])
    couplings = random_couplings(OFFSETS, 400)
    out, expected = sorted_sides(couplings, points).push, np.zeros((points, 3))
    for i in np.flatnonzero(couplings.acts):
        (a, b), (s, t) = couplings.segments[i], couplings.fractions[i]
        for place, weight in ((a, 1 - s), (a + 1, s), (b, t - 1), (b + 1, -t)):
            expected[place] += weight * couplings.push[i]
    np.testing.assert_allclose(out, expected, atol=1e-12)
    np.testing.assert_allclose(out.sum(axis=0), 0, atol=1e-11)


def test_no_strand_gets_a_term_of_its_neighbour():
    points = int(OFFSETS[-1])
    _, following = blocks(random_couplings(OFFSETS, 4000), points)
    assert not following[OFFSETS[1:] - 1].any()
    assert np.count_nonzero(following.any(axis=1)) > points / 2


def test_threads_and_the_way_sets_are_joined_change_no_bit(threads):
    points = int(OFFSETS[-1])
    couplings = random_couplings(OFFSETS, 3000)
    parts = part_of(couplings, 0, 1000), part_of(couplings, 1000, 3000)
    exerted = (np.concatenate(fields) for fields in list(zip(*parts, strict=True))[2:])
    whole = Couplings(*join(*parts), *exerted)
    v = np.random.default_rng(1).normal(size=(points, 3))
    results = []
    for number, same in ((1, couplings), (numba.get_num_threads(), whole)):
        threads(number)
        results.append([*sorted_sides(same, points), multiply(same, points, v)])
    for one, other in zip(*results, strict=True):
        assert np.array_equal(one, other)


def test_none_at_all_does_nothing():
    v = np.ones((4, 3))
    assert not multiply(part_of(random_couplings(OFFSETS, 10), 0, 0), 4, v).any()


def test_nan_stays_in_coupled_strands():
    points = int(OFFSETS[-1])
    couplings = random_couplings(OFFSETS, 50)
    v = np.ones((points, 3))
    a, b = couplings.segments[np.flatnonzero(couplings.acts)[7]]
    v[a] = np.nan
    lost = np.flatnonzero(np.isnan(multiply(couplings, points, v)).any(axis=1))
    assert {b, b + 1} <= set(lost) and len(lost) < 50


def test_impulses_after_a_change_are_those_of_the_whole_matrix():
    """J^T (push - M J dv), in one go, and bit by bit: the other strands' part, then the own one."""
    offsets = np.array([0, 2, 7, 16, 19], np.int32)
    points, active = 19, np.ones(19, bool)
    couplings = random_couplings(offsets, 60)
    sides = sorted_sides(couplings, points)
    dv = np.random.default_rng(4).normal(size=(points, 3))
    push = sides.push.copy()
    expected = push - (whole_matrix(couplings, points) @ dv.ravel()).reshape(-1, 3)
    out, total = np.empty_like(push), np.zeros_like(push)
    impulses_after(sides, dv, active, out)
    np.testing.assert_allclose(out, expected, atol=SINGLE * np.abs(expected).max())
    follow(sides, dv, active, total, push)
    np.testing.assert_allclose(push - multiply(couplings, points, dv), expected, atol=SINGLE * np.abs(expected).max())
    np.testing.assert_array_equal(total, dv)


def test_a_lost_strand_takes_no_other_along():
    points, active = int(OFFSETS[-1]), np.ones(OFFSETS[-1], bool)
    couplings = random_couplings(OFFSETS, 400)
    sides = sorted_sides(couplings, points)
    dv, total, received = np.ones((points, 3)), np.zeros((points, 3)), np.zeros((points, 3))
    lost = slice(OFFSETS[1], OFFSETS[2])
    dv[lost] = np.nan
    follow(sides, dv, active, total, received)
    assert not total[lost].any() and np.isfinite(total).all()
    assert np.isfinite(np.delete(received, np.r_[lost], axis=0)).all()
