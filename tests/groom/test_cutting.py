"""How many segments strands get."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.groom.resampling import Cut, fitting
from hairpipe.groom.settings import SHORTEST
from hairpipe.strands.calibration import softenings
from hairpipe.strands.material import Material


def test_messages_are_not_repeated():
    with pytest.raises(BadInput, match=r"segments = 9 and segment_length = 0.01 are both given \(one of the two\)"):
        Cut(9, 0.01)


def test_segments_by_number_length_or_default():
    lengths = np.array([0.0095, 0.01, 0.0501])
    assert Cut(7).wanted(lengths, 50).tolist() == [7, 7, 7]
    assert Cut(segment_length=0.01).wanted(lengths, 50).tolist() == [1, 1, 6]
    assert Cut().wanted(lengths, 50).tolist() == [50, 50, 50]
    assert int(Cut(segment_length=0.01).wanted(0.3, 50)) == 30


def test_curls_have_sixteen_segments_per_turn_and_straight_hair_one_per_5_mm():
    lengths, turns = np.array([0.3, 0.3, 0.3, 0.02, 9.0]), np.array([np.inf, 0.099, 0.03, 0.001, np.inf])
    counts = fitting(lengths, turns)
    assert counts.tolist() == [60, 60, 160, 200, 200]
    assert (counts * turns / lengths >= 15.99)[:3].all()


def test_the_shortest_segment_is_a_rod_of_common_hair():
    given = Material().softening
    found = softenings(Material(), np.array([SHORTEST, 0.6 * SHORTEST]))
    assert found[0] == given > found[1]
