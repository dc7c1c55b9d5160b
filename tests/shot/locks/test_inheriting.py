"""The connections of hairs that a guide leads from now on are the guide's."""

import numpy as np

from hairpipe.contact.stiction import Connections
from hairpipe.shot.locks import inherited

OFFSETS = np.arange(0, 21, 5, dtype=np.int32)
LEADERS = np.array([2, 1, 2, 3], np.int32)
"""Strand 0 follows strand 2 from now on."""


def test_inherited_connections_keep_place_and_age():
    connections = Connections(
        np.array([[1, 7], [3, 13], [6, 18]], np.int32), np.array([[0.1, 0.9], [0.5, 0.5], [0.3, 0.4]])
    )
    found, ages = inherited(connections, np.array([5, 6, 7]), LEADERS, OFFSETS, 5)
    # 1 - 7 is now 11 - 7, the lower first; what tied 0 to 2 has ended; 6 - 18 is as it was.
    np.testing.assert_array_equal(found.segments, [[6, 18], [7, 11]])
    np.testing.assert_array_equal(found.fractions, [[0.3, 0.4], [0.9, 0.1]])
    np.testing.assert_array_equal(ages, [7, 5])


def test_a_segment_has_no_more_than_it_may_and_its_own_come_first():
    connections = Connections(np.array([[1, 5], [1, 6], [7, 11]], np.int32), np.full((3, 2), 0.5))
    for closest, expected in ((1, [[7, 11]]), (2, [[6, 11], [7, 11]]), (3, [[5, 11], [6, 11], [7, 11]])):
        found, _ = inherited(connections, np.array([1, 8, 0]), LEADERS, OFFSETS, closest)
        np.testing.assert_array_equal(found.segments, expected)


def test_nothing_changes_where_all_lead_themselves():
    connections = Connections(np.array([[1, 7], [3, 13]], np.int32), np.array([[0.1, 0.9], [0.5, 0.5]]))
    found, ages = inherited(connections, np.array([2, 3]), np.arange(4, dtype=np.int32), OFFSETS, 5)
    np.testing.assert_array_equal(found.segments, connections.segments)
    np.testing.assert_array_equal(found.fractions, connections.fractions)
    np.testing.assert_array_equal(ages, [2, 3])
