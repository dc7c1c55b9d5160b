"""Joined grooms keep their strands, and joined ends lead them."""

import numpy as np
import pytest

from hairpipe.body.scripted_motion import Track, drive
from hairpipe.errors import BadInput
from hairpipe.groom.sampling import joined_ends, joined_strands
from hairpipe.groom.strands import lay_strands


def test_strands_and_ends_stay_together():
    one = lay_strands(2, 0.1, 5, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    two = lay_strands(1, 0.2, 8, (0.0, 1.0, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    both = joined_strands((one, two))
    assert both.offsets.tolist() == [0, 6, 12, 21] and both.ids.tolist() == [0, 1, 2]
    assert both.offsets.dtype == both.ids.dtype == np.int32
    np.testing.assert_array_equal(both.points, np.concatenate([one.points, two.points]))
    np.testing.assert_array_equal(both.root_frames[2], two.root_frames[0])
    led = (
        drive(one, 0.0, Track(), None, None, None),
        drive(two, 0.0, Track((0.0,), ((1.0, 2.0, 3.0),)), None, Track(), None),
    )
    ends = joined_ends(led)
    assert ends.roots.shape == (3, 3, 4) and ends.roots[2, :, 3].tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(ends.tips[:2]).all() and np.isfinite(ends.tips[2]).all()


def test_grooms_become_groups_by_name():
    one, two, three = (lay_strands(n, 0.1, 5, (1.0, 0.0, 0.0), (0.0, 0.0, 0.01), None, 0.0) for n in (2, 1, 3))
    both = joined_strands((one, two, three), ("fringe", "beard", "fringe"))
    assert [both.group_names[group] for group in both.groups] == ["fringe"] * 2 + ["beard"] + ["fringe"] * 3
    with pytest.raises(BadInput, match="2 names for 3 grooms"):
        joined_strands((one, two, three), ("fringe", "beard"))
