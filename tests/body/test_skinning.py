import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.skinning import skin
from hairpipe.data import Body, Mesh, Pose, Skeleton
from hairpipe.errors import BadInput

CHANCE = np.random.default_rng(8)
TRIANGLES = np.array([[0, 1, 2], [2, 1, 3]], np.int32)


def rigid(rotation: Rotation, shift) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation.as_matrix()
    matrix[:3, 3] = shift
    return matrix


def random_rigid() -> np.ndarray:
    return rigid(Rotation.random(random_state=CHANCE.integers(1 << 30)), CHANCE.normal(size=3))


def make_body(count: int, joints: int) -> Body:
    points = CHANCE.normal(size=(count, 3))
    rest = np.array([random_rigid() for _ in range(joints)])
    skeleton = Skeleton(tuple(f"j{i}" for i in range(joints)), np.full(joints, -1, np.int32), rest, rest[:, :3, 3])
    weights = CHANCE.dirichlet(np.ones(joints), count)
    order = np.tile(np.arange(joints, dtype=np.int32), (count, 1))
    uv = CHANCE.uniform(size=(2, 3, 2)).astype(np.float32)
    return Body(Mesh(points, TRIANGLES, uv=uv), skeleton, order, weights)


def still(transforms: np.ndarray) -> Pose:
    return Pose(transforms, np.zeros_like(transforms))


def test_the_rest_pose_gives_the_rest_mesh():
    body = make_body(20, 3)
    mesh = skin(body, still(body.skeleton.rest))
    np.testing.assert_allclose(mesh.points, body.mesh.points, atol=1e-12)
    np.testing.assert_array_equal(mesh.velocities, 0.0)


def test_without_a_pose_the_mesh_rests():
    body = make_body(20, 3)
    mesh = skin(body, None)
    np.testing.assert_array_equal(mesh.points, body.mesh.points)
    np.testing.assert_array_equal(mesh.velocities, 0.0)
    assert mesh.velocities.shape == mesh.points.shape


def test_moving_every_joint_alike_moves_the_body_as_a_whole():
    body, whole = make_body(20, 3), random_rigid()
    mesh = skin(body, still(whole @ body.skeleton.rest))
    np.testing.assert_allclose(mesh.points, body.mesh.points @ whole[:3, :3].T + whole[:3, 3], atol=1e-12)


def test_a_vertex_is_the_mean_of_where_its_joints_would_carry_it():
    body = make_body(20, 4)
    poses = np.array([random_rigid() for _ in range(4)])
    carried = []
    for pose, rest in zip(poses, body.skeleton.rest, strict=True):
        move = pose @ np.linalg.inv(rest)
        carried.append(body.mesh.points @ move[:3, :3].T + move[:3, 3])
    expected = np.einsum("nj,jna->na", body.weights, np.array(carried))
    np.testing.assert_allclose(skin(body, still(poses)).points, expected, atol=1e-12)


def test_a_shoulder_half_way_of_a_half_turn_collapses_onto_the_axis():
    """The closed form of the well-known fault of linear blending: R(0) and R(180 deg) cancel across the axis."""
    rest = np.tile(np.eye(4), (2, 1, 1))
    skeleton = Skeleton(("a", "b"), np.array([-1, 0], np.int32), rest, rest[:, :3, 3])
    body = Body(
        Mesh(np.array([[1.0, 2.0, 3.0]]), TRIANGLES[:0]), skeleton, np.array([[0, 1]], np.int32), np.array([[0.5, 0.5]])
    )
    twist = rigid(Rotation.from_euler("x", 180.0, degrees=True), np.zeros(3))
    np.testing.assert_allclose(skin(body, still(np.array([np.eye(4), twist]))).points, [[1.0, 0.0, 0.0]], atol=1e-12)


def pose_of_time(rest: np.ndarray, t: float) -> np.ndarray:
    moves = [rigid(Rotation.from_rotvec([0.3 * t + i, t * t, -0.5 * t]), [t, i * t, t**2]) for i in range(len(rest))]
    return np.array(moves) @ rest


def test_velocities_are_the_derivative_of_positions():
    body, t, step = make_body(20, 3), 0.7, 1e-5
    rest = body.skeleton.rest
    rates = (pose_of_time(rest, t + step) - pose_of_time(rest, t - step)) / (2.0 * step)
    mesh = skin(body, Pose(pose_of_time(rest, t), rates))
    before, after = (skin(body, still(pose_of_time(rest, t + s))).points for s in (-step, step))
    np.testing.assert_allclose(mesh.velocities, (after - before) / (2.0 * step), atol=1e-8)


def test_a_spinning_joint_gives_the_velocity_of_a_rigid_body():
    body = make_body(20, 1)
    spin = np.array([0.3, -2.0, 0.9])
    cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
    rates = np.zeros((1, 4, 4))
    rates[0, :3] = cross @ body.skeleton.rest[0, :3]
    mesh = skin(body, Pose(body.skeleton.rest, rates))
    np.testing.assert_allclose(mesh.velocities, np.cross(spin, body.mesh.points), atol=1e-12)


def test_triangles_and_texture_are_passed_on():
    body = make_body(20, 2)
    mesh = skin(body, still(body.skeleton.rest))
    np.testing.assert_array_equal(mesh.triangles, body.mesh.triangles)
    np.testing.assert_array_equal(mesh.uv, body.mesh.uv)


@pytest.mark.parametrize("extra", [1, 3])
def test_joints_of_no_weight_do_not_count(extra):
    body = make_body(20, 2)
    padded = Body(
        body.mesh,
        body.skeleton,
        np.concatenate([body.joints, np.zeros((20, extra), np.int32)], axis=1),
        np.concatenate([body.weights, np.zeros((20, extra))], axis=1),
    )
    pose = still(np.array([random_rigid() for _ in range(2)]))
    assert skin(padded, pose).points.tobytes() == skin(body, pose).points.tobytes()


@pytest.mark.parametrize("joints", [1, 2, 4])
def test_a_pose_of_another_skeleton_is_refused(joints):
    pose = still(np.tile(np.eye(4), (joints, 1, 1)))
    with pytest.raises(BadInput, match=f"in.pose: a pose of {joints} joints, the body has 3"):
        skin(make_body(20, 3), pose)
