"""Putting points right at the end of a step stretches no segment too far."""

import numpy as np

from hairpipe.levelset.moving import Probe
from hairpipe.sim.contact.project import Motion, project


def test_points_that_are_pushed_apart_stay_together():
    """Neighbours are pushed to opposite sides, 5 mm each, as where two bodies close on them."""
    rng = np.random.default_rng(4)
    strand = np.stack([np.arange(20) * 0.01, np.zeros(20), np.zeros(20)], axis=1)
    points = np.concatenate([strand, strand + 1.0]) + rng.normal(0.0, 1e-3, (40, 3))
    mass = np.where(np.arange(40) % 20 == 0, np.inf, 1e-8)
    normals = np.zeros((40, 3))
    normals[:, 1] = np.where(np.arange(40) % 2 == 0, 1.0, -1.0)
    ended = Probe(np.full(40, -4e-3), normals, np.zeros((40, 3)))
    motion = Motion(points, points, np.zeros((40, 3)), np.zeros(40), np.full(40, 1e-3), mass)
    nobody = np.empty(0, np.int64), np.empty(0), Probe.blank(0), np.empty((0, 3))
    dx = project(motion, ended, *nobody, 1e-3, 0.0)[0]
    before, after = (np.linalg.norm(np.diff(p.reshape(2, 20, 3), axis=1), axis=2) for p in (points, points + dx))
    assert (after <= 1.1 * before + 1e-12).all() and not dx[mass == np.inf].any()
    freely = motion._replace(begun=np.full(40, -3.9e-3))
    dx = project(freely, ended, *nobody, 1e-3, 0.0)[0]
    np.testing.assert_allclose(dx[mass < np.inf], 6e-4 * normals[mass < np.inf], atol=1e-15)


def test_what_slid_around_a_body_stays_where_it_is_and_what_went_through_is_stopped():
    """Both ways cross the unit ball; the first by a corner, the second through its middle."""
    before = np.array([[-0.5, 1.0, 0.0], [-0.5, 1.0, 0.0]]) * 1.05
    after = np.array([[0.5, 1.0, 0.0], [0.5, -1.0, 0.0]]) * 1.05
    ends = after / np.linalg.norm(after, axis=1)[:, None]
    far = Probe.blank(2)
    met, shares = np.arange(2), np.full(2, 0.25)
    meeting = Probe(np.zeros(2), np.tile([0.0, 1.0, 0.0], (2, 1)), np.zeros((2, 3)))
    motion = Motion(before, after, after - before, np.full(2, 0.05), np.full(2, 1e-3), np.full(2, 1e-8))
    for first in (0, 1):
        who = [first, 1]
        moved = motion._replace(before=before[who], after=after[who])
        dx, _, touched, _ = project(moved, far, met, shares, meeting, ends[who], 1.0, 0.0)
        assert touched.tolist() == [first == 1, True]
        assert first == 1 or not dx[0].any()
        np.testing.assert_allclose(dx[1, 1], 0.75 * 2.1, rtol=1e-12)
