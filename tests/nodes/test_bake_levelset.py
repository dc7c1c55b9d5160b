"""The bake_levelset node."""

import numpy as np
import pytest

from hairpipe.data import Mesh
from hairpipe.errors import BadInput
from hairpipe.nodes.bake_levelset import bake_levelset

TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)


def test_settings_reach_the_level_set():
    surface = bake_levelset(Mesh(TETRAHEDRON, FACES), voxel=0.05, half_width=4.0)
    assert (surface.voxel, surface.half_width) == (0.05, 4.0)
    assert surface.distance.min() < -0.1
    assert np.abs(surface.distance).max() == np.float32(0.2)


def test_holes_are_refused_on_request():
    opened = Mesh(TETRAHEDRON, FACES[1:])
    with pytest.raises(BadInput, match="the surface is open: 1 hole: 3 edges"):
        bake_levelset(opened, voxel=0.05, half_width=4.0, holes="refuse")
    with pytest.warns(UserWarning, match="capped 1 hole"):
        filled = bake_levelset(opened, voxel=0.05, half_width=4.0)
    whole = bake_levelset(Mesh(TETRAHEDRON, FACES), voxel=0.05, half_width=4.0)
    assert np.allclose(filled.distance, whole.distance, atol=1e-6)
