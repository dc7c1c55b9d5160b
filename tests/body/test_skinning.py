from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.skinning import skin
from hairpipe.errors import BadInput
from hairpipe.nodes.pose_body import pose_body
from hairpipe.values import BlendShapes, Body, Bound, DualQuaternions, Mesh, Pose, Skeleton

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


def test_the_node_poses_the_body():
    body = make_body(20, 3)
    pose = still(random_rigid() @ body.skeleton.rest)
    assert np.array_equal(pose_body(body, pose).points, skin(body, pose).points)
    assert np.array_equal(pose_body(body).points, body.mesh.points)


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


def test_dual_quaternions_half_way_of_a_screw_turn_by_half_of_it():
    """Half of a screw is half of its turn and half of its way along the axis."""
    rest = np.tile(np.eye(4), (2, 1, 1))
    skeleton = Skeleton(("a", "b"), np.array([-1, 0], np.int32), rest, rest[:, :3, 3])
    dual = DualQuaternions(np.array([0], np.int32), np.zeros((1, 3)))
    weights = np.array([[0.5, 0.5]])
    body = Body(
        Mesh(np.array([[1.0, 2.0, 3.0]]), TRIANGLES[:0]), skeleton, np.array([[0, 1]], np.int32), weights, dual=dual
    )
    twist = rigid(Rotation.from_euler("x", 120.0, degrees=True), np.array([4.0, 0.0, 0.0]))
    half = Rotation.from_euler("x", 60.0, degrees=True).apply([1.0, 2.0, 3.0]) + np.array([2.0, 0.0, 0.0])
    np.testing.assert_allclose(skin(body, still(np.array([np.eye(4), twist]))).points, [half], atol=1e-12)


@pytest.mark.parametrize("scales", [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (1.5, 1.5, -1.5), (0.0, 1.0, 2.0)])
def test_dual_quaternions_of_one_joint_are_its_matrix_at_scales_of_0_and_mirrors(scales):
    body = make_body(6, 1)
    body = replace(body, dual=DualQuaternions(np.arange(6, dtype=np.int32), np.zeros((6, 3))))
    moved, rates = random_rigid(), np.zeros((1, 4, 4))
    moved[:3, :3] = moved[:3, :3] @ np.diag(scales)
    rates[0, :3] = CHANCE.normal(size=(3, 4))
    pose = Pose((moved @ body.skeleton.rest[0])[None], rates @ body.skeleton.rest[0])
    found = skin(body, pose)
    points = np.concatenate([body.mesh.points, np.ones((6, 1))], axis=1)
    np.testing.assert_allclose(found.points, points @ moved[:3].T, atol=1e-12)
    np.testing.assert_allclose(found.velocities, points @ rates[0, :3].T, atol=1e-12)


def rich_body() -> Body:
    """A body with all that moves a skin: dual quaternions, blend shapes, and another mesh that is bound."""
    body = make_body(20, 3)
    turns = np.array([random_rigid() for _ in range(3)])
    turns[:, :3, :3] *= 1.3
    shapes = BlendShapes(
        ("smile", "puff"),
        np.array([0.0, 0.25]),
        np.array([0, 0, 1], np.int32),
        np.zeros(3, np.int32),
        np.array([0.5, 1.0, 1.0]),
        np.array([0, 4, 8, 28]),
        np.concatenate([[3, 4, 7, 9], [3, 4, 7, 9], np.arange(20)]).astype(np.int32),
        CHANCE.normal(size=(28, 3)),
    )
    dual = DualQuaternions(np.arange(5, 15, dtype=np.int32), CHANCE.normal(size=(10, 3)))
    return replace(body, dual=dual, shapes=shapes, bound=Bound(CHANCE.normal(size=(20, 3)), turns))


def rich_pose(body: Body, t: float) -> Pose:
    """A pose in which joints turn and stretch, and weights change."""
    step = 1e-6
    early, late = (pose_of_time(body.skeleton.rest, t + s) * stretch(t + s) for s in (-step, step))
    now = pose_of_time(body.skeleton.rest, t) * stretch(t)
    return Pose(now, (late - early) / (2 * step), np.array([0.3 + t * t, -t]), np.array([2.0 * t, -1.0]))


def stretch(t: float) -> np.ndarray:
    return np.array([1.0 + 0.2 * t, 1.0, 1.0 - 0.1 * t, 1.0])


def test_velocities_are_the_derivative_of_positions_with_all_that_moves_a_skin():
    body, t, step = rich_body(), 0.7, 1e-5
    before, now, after = (skin(body, rich_pose(body, t + s)) for s in (-step, 0.0, step))
    np.testing.assert_allclose(now.velocities, (after.points - before.points) / (2.0 * step), atol=1e-6)
    assert np.abs(now.velocities).min() > 1e-3


@pytest.mark.parametrize("weight", [-0.5, 0.0, 0.2, 0.5, 0.9, 1.5])
def test_blend_shapes_are_linear_between_their_keys(weight):
    body = replace(rich_body(), dual=None, bound=None)
    pose = replace(still(body.skeleton.rest), weights=np.array([weight, 0.0]))
    shapes = body.shapes
    half, full = shapes.offsets[:4], shapes.offsets[4:8]
    expected = 2 * weight * half if weight <= 0.5 else half + (2 * weight - 1.0) * (full - half)
    moved = skin(body, pose).points - body.mesh.points
    np.testing.assert_allclose(moved[[3, 4, 7, 9]], expected, atol=1e-12)
    np.testing.assert_allclose(moved[[0, 1, 2]], 0.0, atol=1e-12)


def test_a_pose_of_other_blend_shapes_is_refused():
    body = rich_body()
    with pytest.raises(BadInput, match=r"in\.pose: a pose of 3 weights, the body has 2 blend shapes"):
        skin(body, replace(rich_pose(body, 0.1), weights=np.zeros(3)))


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
