import numpy as np

from hairpipe.nodes.pose_body import pose_body
from hairpipe.values import Body, Mesh, Pose, Skeleton


def make_body() -> Body:
    rest = np.eye(4)[None]
    skeleton = Skeleton(("a",), np.array([-1], np.int32), rest, rest[:, :3, 3])
    points = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    mesh = Mesh(points, np.array([[0, 1, 2]], np.int32))
    return Body(mesh, skeleton, np.zeros((3, 1), np.int32), np.ones((3, 1)))


def test_the_skin_moves_with_its_joint():
    shift, rate = np.eye(4)[None].copy(), np.zeros((1, 4, 4))
    shift[0, :3, 3], rate[0, :3, 3] = (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)
    mesh = pose_body(make_body(), Pose(shift, rate))
    np.testing.assert_allclose(mesh.points, make_body().mesh.points + np.array([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(mesh.velocities, np.tile((4.0, 5.0, 6.0), (3, 1)))


def test_without_a_pose_it_rests():
    mesh = pose_body(make_body())
    np.testing.assert_array_equal(mesh.points, make_body().mesh.points)
    np.testing.assert_array_equal(mesh.velocities, 0.0)
