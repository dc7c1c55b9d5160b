"""Points put right at the end of a step, on strands that keep their length."""

import numpy as np
import pytest

from hairpipe.contact.body_projection import Motion, drape, farthest, keep_lengths, project
from hairpipe.geometry.collider import SdfSample
from hairpipe.solve.stretch import STRETCH


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


KEPT, SEGMENT, COUNT = 1e-3, 0.012, 26
NEVER = np.full(COUNT, np.inf)


def bar(radius):
    """A round bar along z."""

    def distance(points):
        across = np.hypot(points[:, 0], points[:, 1])
        return across - radius, points * [1.0, 1.0, 0.0] / np.maximum(across, 1e-12)[:, None]

    return distance


def plate(thickness):
    """A plate across y."""

    def distance(points):
        normals = np.zeros_like(points)
        normals[:, 1] = np.sign(points[:, 1])
        return np.abs(points[:, 1]) - 0.5 * thickness, normals

    return distance


def drop(body, points):
    """Move a strand out of a body, first point held; return where it is then, and its distances [m]."""
    masses = np.where(np.arange(len(points)) == 0, np.inf, 1e-8)

    def look(places, which):
        depth, normals = body(places)
        near = (depth < 2 * KEPT)[:, None]
        return SdfSample(depth, np.where(near, normals, 0.0), 0 * normals), np.full(len(places), KEPT)

    probe, _ = look(points, None)
    normals = np.where(((probe.distance < KEPT) & np.isfinite(masses))[:, None], probe.normal, 0.0)
    dx = np.maximum(KEPT - probe.distance, 0.0)[:, None] * normals
    drape(points, dx, normals, NEVER[: len(points)], masses, look)
    return points + dx, body(points + dx)[0]


@pytest.mark.parametrize("radius", [0.004, 0.01, 0.05])
def test_a_strand_across_a_bar_slides_around_it(radius):
    """Through its middle, and beside it: pushed to opposite sides, and along itself."""
    rng = np.random.default_rng(1)
    for offset in np.linspace(-0.9, 0.9, 7):
        along = np.arange(COUNT) * SEGMENT - radius - 0.02
        points = np.stack([along, np.full(COUNT, offset * radius), 0 * along], axis=1)
        points[1:] += rng.normal(0.0, 1e-3, (COUNT - 1, 3))
        ended, distances = drop(bar(radius), points)
        before, after = (np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (points, ended))
        assert (after <= (1 + STRETCH) * before + 1e-12).all()
        assert (distances[1:] > 0.0).all()
        np.testing.assert_array_equal(ended[0], points[0])


def test_a_strand_that_hooks_a_plate_comes_back():
    """The plate is so thick that no segment reaches across: what is beyond is laid on the side of the root."""
    points = np.stack([0.002 * np.arange(COUNT), 0.019 - 0.0115 * np.arange(COUNT), np.zeros(COUNT)], axis=1)
    ended, distances = drop(plate(0.03), points)
    assert (ended[:, 1] > 0.0).all() and (distances[1:] > 0.0).all()


def test_outside_points_are_unchanged():
    points = np.stack([SEGMENT * np.arange(COUNT), np.full(COUNT, 0.05), np.zeros(COUNT)], axis=1)
    np.testing.assert_array_equal(drop(bar(0.03), points)[0], points)


def test_no_segment_is_stretched_too_far():
    """Neighbours are pushed to opposite sides, 5 mm each, as where two bodies close on them."""
    rng = np.random.default_rng(4)
    strand = np.stack([np.arange(20) * 0.01, np.zeros(20), np.zeros(20)], axis=1)
    points = np.concatenate([strand, strand + 1.0]) + rng.normal(0.0, 1e-3, (40, 3))
    masses = np.where(np.arange(40) % 20 == 0, np.inf, 1e-8)
    normals = np.zeros((40, 3))
    normals[:, 1] = np.where(np.arange(40) % 2 == 0, 1.0, -1.0)
    normals[::20] = 0.0
    moved = points + 5e-3 * normals
    keep_lengths(points, normals, masses, moved)
    before, after = (np.linalg.norm(np.diff(p.reshape(2, 20, 3), axis=1), axis=2) for p in (points, moved))
    assert (after <= (1 + STRETCH) * before + 1e-12).all()
    np.testing.assert_array_equal(moved[::20], points[::20])
