"""Hair against the same hair in other segments."""

import numpy as np
import pytest

from hairpipe.measure.deviation import deviation
from hairpipe.values import Strands


def straight(lengths, segments, shift=0.0, rate=0.0):
    """Strands that hang down, shifted along X, the more the farther from the root at this rate."""
    points, offsets = [], [0]
    for strand, (length, count) in enumerate(zip(lengths, segments, strict=True)):
        share = np.linspace(0.0, 1.0, count + 1)
        points.append(np.stack([shift + rate * share * length, -share * length, np.full(count + 1, strand)], axis=1))
        offsets.append(offsets[-1] + count + 1)
    points = np.concatenate(points).astype(np.float32)
    return Strands(points, np.zeros_like(points), np.array(offsets, np.int32), 8e-5)


def test_straight_hair_is_the_same_in_any_number_of_segments():
    found = deviation(straight([0.1, 0.3], [3, 7]), straight([0.1, 0.3], [10, 4]))
    assert max(found[:5]) == pytest.approx(0.0, abs=1e-5) and not len(found.lost)


def test_lengths_and_shares_of_a_difference_that_is_known():
    reference = straight([0.1, 0.3], [10, 10])
    found = deviation(straight([0.1, 0.3], [2, 5], rate=0.5), reference)
    share = np.arange(1, 11) / 10
    rms = np.sqrt(np.mean(share**2))
    assert found.tip == pytest.approx(0.5 * np.sqrt((0.1**2 + 0.3**2) / 2), rel=1e-5)
    assert found.whole == pytest.approx(rms * found.tip, rel=1e-5)
    assert (found.tip_percent, found.whole_percent) == pytest.approx((50.0, 50.0 * rms), rel=1e-5)
    assert found.largest == pytest.approx(0.15, rel=1e-5)


def test_a_strand_counts_as_one_however_many_points_it_has():
    hair = straight([0.1, 0.1], [4, 4])
    hair.points[:5, 0] += 1e-3
    rms = [deviation(hair, straight([0.1, 0.1], cut)).whole for cut in ([40, 2], [2, 40])]
    assert rms == pytest.approx([1e-3 / np.sqrt(2)] * 2, rel=1e-4)


def test_strands_that_are_not_finite_are_named_and_left_out():
    hair = straight([0.1, 0.2, 0.3], [5, 5, 5], shift=1e-3)
    hair.points[8] = np.nan
    found = deviation(hair, straight([0.1, 0.2, 0.3], [5, 5, 5]))
    assert found.lost.tolist() == [1] and found.tip == pytest.approx(1e-3, rel=1e-3)
    hair.points[:, 1] = np.inf
    found = deviation(hair, straight([0.1, 0.2, 0.3], [5, 5, 5]))
    assert found.lost.tolist() == [0, 1, 2] and np.isnan(found[:5]).all()


def test_some_strands_of_a_head_are_compared_with_themselves():
    head = straight([0.1, 0.2, 0.3], [5, 5, 5])
    some = straight([0.3, 0.1], [5, 5])
    some.points[:, 2] = np.repeat([2, 0], 6)
    assert deviation(some, head, np.array([2, 0])).largest == pytest.approx(0.0, abs=1e-7)
    with pytest.raises(ValueError, match="2 strands against 3 of 3"):
        deviation(some, head)
