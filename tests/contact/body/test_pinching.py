"""Hair between bodies that leave it less room than it wants."""

import numpy as np
import pytest

from hairpipe.contact.body import share_gap
from hairpipe.geometry.collider import SdfSample

THICK = 1e-3


class Plate:
    """A half space below or above a height [m] that does not move."""

    def __init__(self, height, up):
        self.height, self.up = height, up

    def probe(self, points, seconds, out):
        distance = self.up * (points[:, 1] - self.height)
        near = distance < out.distance
        out.distance[near] = distance[near]
        out.normal[near] = [0.0, self.up, 0.0]

    def sweep(self, walk, start, end, out):
        raise AssertionError("points that are moved out of surfaces do not sweep along them")


def settle(gap, start, kept, rounds=50):
    """Where points end that are moved out of the nearest of two plates, again and again, (P,) [m]."""
    plates = [Plate(0.0, 1.0), Plate(gap, -1.0)]
    points = np.column_stack([0 * start, start, 0 * start])
    thickness = np.full(len(start), THICK)
    for _ in range(rounds):
        probe = SdfSample.blank(len(points), 0.1)
        for plate in plates:
            plate.probe(points, 0.0, probe)
        room = share_gap(points, 0.0, plates, probe, thickness, kept)
        points[:, 1] += np.maximum(room - probe.distance, 0.0) * probe.normal[:, 1]
    return points[:, 1]


@pytest.mark.parametrize("gap", [1.5e-3, 0.5e-3, 0.0, -1e-3])
def test_points_come_to_rest_in_the_middle(gap):
    start = np.linspace(min(0.0, gap) - 1e-3, max(0.0, gap) + 1e-3, 9)
    ends = settle(gap, start, np.full(9, THICK))
    np.testing.assert_allclose(ends, 0.5 * gap, atol=1.01e-4)


def test_where_there_is_room_nothing_changes():
    points = np.array([[0.0, y, 0.0] for y in (-2e-3, 2e-4, 1e-3, 9.5e-3, 5e-3)])
    plates, kept = [Plate(0.0, 1.0), Plate(1e-2, -1.0)], np.full(5, THICK)
    probe = SdfSample.blank(5, 0.1)
    for plate in plates:
        plate.probe(points, 0.0, probe)
    np.testing.assert_array_equal(share_gap(points, 0.0, plates, probe, kept, kept), kept)


def test_points_that_keep_more_from_one_side_share_the_room():
    """Two heights of a curl over the lower plate keep their order under the upper one."""
    ends = settle(3e-3, np.array([0.5e-3, 0.6e-3]), np.array([1.5e-3, 3e-3]), rounds=1)
    assert 0.0 < ends[0] < ends[1] < 3e-3
    np.testing.assert_allclose(ends[1], 3e-3 * 3.0 / 4.0)


def test_held_roots_inside_a_body_are_accepted():
    points, nothing = np.array([[0.0, -1e-3, 0.0]]), np.zeros(1)
    plates = [Plate(0.0, 1.0), Plate(-1e-4, -1.0)]
    probe = SdfSample.blank(1, 0.1)
    for plate in plates:
        plate.probe(points, 0.0, probe)
    assert np.isfinite(share_gap(points, 0.0, plates, probe, nothing, nothing)).all()
