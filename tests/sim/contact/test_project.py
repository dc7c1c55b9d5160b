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
    nobody = np.empty(0, np.int64), np.empty(0), Probe.blank(0)
    dx = project(motion, ended, *nobody, 1e-3, 0.0)[0]
    before, after = (np.linalg.norm(np.diff(p.reshape(2, 20, 3), axis=1), axis=2) for p in (points, points + dx))
    assert (after <= 1.1 * before + 1e-12).all() and not dx[mass == np.inf].any()
    freely = motion._replace(begun=np.full(40, -3.9e-3))
    dx = project(freely, ended, *nobody, 1e-3, 0.0)[0]
    np.testing.assert_allclose(dx[mass < np.inf], 6e-4 * normals[mass < np.inf], atol=1e-15)
