"""Clumps: tips come nearer to a key, roots stay, nothing is stretched."""

import numpy as np
import pytest

from hairpipe.nodes.interpolate_hair import Clumps
from hairpipe.values.groom import segment_lengths
from hairpipe.values.strand_arrays import take


def test_tips_of_parallel_hair_come_as_near_as_they_can(row, at, shown):
    key = take(row, np.array([0]))
    found = shown(at(key, key.points), key, row, clumps=Clumps(pull=1.0, begin=0.5)).points.reshape(4, 7, 3)
    apart = np.linalg.norm(found - found[:1], axis=2)
    assert apart[:, :4] == pytest.approx(np.tile(0.01 * np.arange(4.0)[:, None], (1, 4)), abs=1e-14)
    assert (np.diff(apart[1:, 3:], axis=1) < 0.0).all()
    assert (apart[1:, -1] < 0.3 * apart[1:, 0]).all()
    assert np.array_equal(found[0], key.points)


def test_no_segment_is_stretched_and_velocities_are_the_derivative(groom, keys, at, bent, shown):
    span, here, clumps = 1e-5, bent(keys, 40.0, 5), Clumps()
    speed = np.random.default_rng(6).normal(size=here.shape)
    before, now, after = (
        shown(at(keys, here + t * speed, speed), keys, groom, clumps=clumps) for t in (-span, 0.0, span)
    )
    rest, lengths = (segment_lengths(some.points, groom.offsets) for some in (groom, now))
    theirs = np.repeat(np.isin(groom.ids, keys.ids), 6)
    assert lengths[~theirs] == pytest.approx(rest[~theirs], rel=1e-12)
    assert now.velocities == pytest.approx((after.points - before.points) / (2 * span), abs=1e-4)


def test_no_pull_leaves_hair_as_it_is(groom, keys, at, bent, shown):
    hair = at(keys, bent(keys, 40.0, 7))
    plain, pulled = (shown(hair, keys, groom, clumps=clumps).points for clumps in (None, Clumps(pull=0.0)))
    assert pulled == pytest.approx(plain, abs=1e-15)
