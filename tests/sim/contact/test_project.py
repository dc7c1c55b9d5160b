"""Putting points right at the end of a step."""

import numpy as np

from hairpipe.levelset.moving import Probe
from hairpipe.sim.contact.project import Motion, farthest, project


def test_what_began_inside_comes_out_slowly():
    """Points 4 mm inside: those that began on the surface are moved out at once, the others by 0.5 m/s."""
    rng = np.random.default_rng(4)
    points, mass = rng.normal(0.0, 0.1, (40, 3)), np.where(np.arange(40) % 20 == 0, np.inf, 1e-8)
    normals = np.zeros((40, 3))
    normals[:, 1] = np.where(np.arange(40) % 2 == 0, 1.0, -1.0)
    ended = Probe(np.full(40, -4e-3), normals, np.zeros((40, 3)))
    begun = np.where(np.arange(40) < 20, 0.0, -3.9e-3)
    motion = Motion(points, points, np.zeros((40, 3)), farthest(begun, 1e-3), np.full(40, 1e-3), mass)
    dx = project(motion, ended, np.empty(0, np.int64), np.empty(0), Probe.blank(0), 1e-3, 0.0)[0]
    way = np.where(np.isinf(mass), 0.0, np.where(begun == 0.0, 5e-3, 6e-4))
    np.testing.assert_allclose(dx, way[:, None] * normals, atol=1e-15)
