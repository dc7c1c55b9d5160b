"""Putting points right at the end of a step."""

import numpy as np

from hairpipe.contact.body_projection import Motion, farthest, project
from hairpipe.geometry.collider import SdfSample


def test_points_that_began_inside_are_unchanged_and_near_ones_rise_slowly():
    """Points 4 mm inside: those that began on the surface are moved by 0.5 m/s, those from outside at once."""
    rng = np.random.default_rng(4)
    points, mass = rng.normal(0.0, 0.1, (40, 3)), np.where(np.arange(40) % 20 == 0, np.inf, 1e-8)
    normals = np.zeros((40, 3))
    normals[:, 1] = np.where(np.arange(40) % 2 == 0, 1.0, -1.0)
    ended = SdfSample(np.full(40, -4e-3), normals, np.zeros((40, 3)))
    start_distance = np.repeat([-3.5e-3, 0.0, -9e-4, 0.1], 10)
    motion = Motion(
        points, points, np.zeros((40, 3)), farthest(start_distance, 1e-3), np.full(40, 1e-3), mass, 1e-3, 0.0
    )
    dx = project(motion, ended, np.empty(0, np.int64), np.empty(0), SdfSample.blank(0), np.empty((0, 3)))[0]
    way = np.where(np.isinf(mass), 0.0, np.repeat([0.0, 4.5e-3, 3.6e-3, 5e-3], 10))
    np.testing.assert_allclose(dx, way[:, None] * normals, atol=1e-15)


def test_sliding_points_are_unchanged_and_crossing_points_stopped():
    """Both ways cross the unit ball; the first by a corner, the second through its middle."""
    before = np.array([[-0.5, 1.0, 0.0], [-0.5, 1.0, 0.0]]) * 1.05
    after = np.array([[0.5, 1.0, 0.0], [0.5, -1.0, 0.0]]) * 1.05
    ends = after / np.linalg.norm(after, axis=1)[:, None]
    far = SdfSample.blank(2)
    met, shares = np.arange(2), np.full(2, 0.25)
    meeting = SdfSample(np.zeros(2), np.tile([0.0, 1.0, 0.0], (2, 1)), np.zeros((2, 3)))
    kept = farthest(np.full(2, 0.05), 1.0), np.full(2, 1e-3)
    motion = Motion(before, after, after - before, *kept, np.full(2, 1e-8), 1.0, 0.0)
    for first in (0, 1):
        active = [first, 1]
        moved = motion._replace(before=before[active], after=after[active])
        dx, _, touched, _ = project(moved, far, met, shares, meeting, ends[active])
        assert touched.tolist() == [first == 1, True]
        assert first == 1 or not dx[0].any()
        np.testing.assert_allclose(dx[1, 1], 0.75 * 2.1, rtol=1e-12)
