import numpy as np
from scipy.spatial.transform import Rotation

from hairpipe.geometry.rotations import Z_UP, invert


def test_inverse_undoes_a_rigid_transform():
    rigid = np.tile(np.eye(4), (3, 1, 1))
    rigid[:, :3, :3] = Rotation.random(3, random_state=1).as_matrix()
    rigid[:, :3, 3] = [(1.0, -2.0, 3.0), (0.0, 0.5, 0.0), (-4.0, 0.0, 1.0)]
    np.testing.assert_allclose(invert(rigid) @ rigid, np.tile(np.eye(4), (3, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(invert(rigid[0]), invert(rigid)[0])


def test_up_becomes_y_and_the_face_looks_along_z():
    np.testing.assert_array_equal(Z_UP @ [0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
    np.testing.assert_array_equal(Z_UP @ [0.0, -1.0, 0.0], [0.0, 0.0, 1.0])
    assert np.linalg.det(Z_UP) == 1.0
