"""A body as a level set for each group of bones: together they are the body, in any pose."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hairpipe.body.bust import build_bust
from hairpipe.body.skinning import skin
from hairpipe.errors import BadInput
from hairpipe.geometry.collider import SdfSample
from hairpipe.levelset.bake import bake
from hairpipe.levelset.bake_parts import bake_once, bake_parts, cut_skin, group_bones, group_weights
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.values import Body, Mesh, Pose, Skeleton

VOXEL, HALF_WIDTH, SMALLEST = 0.01, 6.0, 0.18


@pytest.fixture(scope="module")
def bust() -> Body:
    return build_bust()


def nodding(body: Body, degrees: float, shift=(0.0, 0.0, 0.0)) -> Pose:
    """Every joint turned by so much in its parent, and all of them shifted."""
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler("xy", [degrees, 2 * degrees], degrees=True).as_matrix()
    rest, parents = body.skeleton.rest, body.skeleton.parents
    found = rest.copy()
    for joint, parent in enumerate(parents):
        local = np.linalg.inv(rest[parent]) @ rest[joint] if parent >= 0 else rest[joint]
        found[joint] = found[parent] @ local @ turn if parent >= 0 else local
    found[:, :3, 3] += shift
    return Pose(found, np.zeros_like(found))


def probed(surface, points: np.ndarray) -> np.ndarray:
    probe = SdfSample.blank(len(points))
    surface.probe(points, 0.0, probe)
    return probe.distance


def off_the_whole(body: Body, pose: Pose | None, smallest: float = SMALLEST) -> np.ndarray:
    """How far the parts are off the level set of the whole body, on it and up to 3 voxels outside [voxels]."""
    parts, mesh = bake_parts(body, pose, VOXEL, HALF_WIDTH, smallest), skin(body, pose)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        still = bake(mesh, VOXEL, HALF_WIDTH)
    chance = np.random.default_rng(0)
    points = mesh.points + chance.uniform(-3, 3, mesh.points.shape) * VOXEL
    whole = probed(build_collider_field(still, still, 1.0, Interpolation.linear), points)
    near = (whole > 0.0) & (whole < 3 * VOXEL)
    assert near.mean() > 0.2
    return (probed(build_collider_parts(parts, parts, 1.0), points[near]) - whole[near]) / VOXEL


@pytest.mark.parametrize("degrees", [None, 12.0])
def test_all_parts_together_are_the_body(bust, degrees):
    off = np.abs(off_the_whole(bust, None if degrees is None else nodding(bust, degrees)))
    assert np.percentile(off, 90) < 0.05 and np.percentile(off, 99) < 0.2 and off.max() < 0.7


def test_one_part_is_the_body(bust):
    assert np.abs(off_the_whole(bust, None, 10.0)).max() < 0.3
    empty = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))
    bare = replace(bust, skeleton=empty, joints=bust.joints[:, :0], weights=bust.weights[:, :0])
    assert bake_parts(bare, None, VOXEL, HALF_WIDTH, SMALLEST).names == ("body",)
    assert np.abs(off_the_whole(bare, None)).max() < 0.01


def test_open_necks_and_shells_within_are_closed(bust, sphere):
    mesh = bust.mesh
    kept = mesh.triangles[mesh.points[mesh.triangles][:, :, 1].min(axis=1) > mesh.points[:, 1].min() + 0.04]
    eye = sphere(0.02, (0.0, 0.33, 0.04), 3)
    points = np.concatenate([mesh.points, eye.points])
    triangles = np.concatenate([kept, eye.triangles + len(mesh.points)]).astype(np.int32)
    joints = np.concatenate([bust.joints, np.full((len(eye.points), 4), 3, np.int32)])
    weights = np.concatenate([bust.weights, np.tile([1.0, 0.0, 0.0, 0.0], (len(eye.points), 1))])
    used = np.unique(triangles)
    place = np.zeros(len(points), np.int32)
    place[used] = np.arange(len(used))
    body = replace(bust, mesh=Mesh(points[used], place[triangles]), joints=joints[used], weights=weights[used], maps={})
    with pytest.warns(UserWarning, match="body: capped 1 hole"):
        off = off_the_whole(body, nodding(bust, 8.0))
    assert np.percentile(np.abs(off), 99) < 0.1


def test_rigid_parts_are_baked_once(bust):
    bake_once.cache_clear()
    first = bake_parts(bust, nodding(bust, 10.0), VOXEL, HALF_WIDTH, SMALLEST)
    again = bake_parts(bust, nodding(bust, 10.0, shift=(0.7, -0.3, 0.1)), VOXEL, HALF_WIDTH, SMALLEST)
    other = bake_parts(bust, nodding(bust, 14.0), VOXEL, HALF_WIDTH, SMALLEST)
    count = len(first.names)
    assert bake_once.cache_info().misses == 2 * count and bake_once.cache_info().hits == count
    assert not build_collider_parts(first, again, 1.0).outlines.changes.any()
    assert build_collider_parts(first, other, 1.0).outlines.changes.any()
    assert np.allclose(again.poses[:, :, 3] - first.poses[:, :, 3], (0.7, -0.3, 0.1))


def test_patches_cover_the_skin_and_overlap(bust):
    cuts = cut_skin(bust, group_bones(bust, SMALLEST), 0.03)
    uses = np.zeros(len(bust.mesh.triangles), int)
    known = {tuple(sorted(t)): n for n, t in enumerate(bust.mesh.triangles.tolist())}
    for cut in cuts:
        for triangle in cut.vertices[cut.triangles].tolist():
            uses[known[tuple(sorted(triangle))]] += 1
    assert uses.min() == 1 and 0.05 < (uses > 1).mean() < 0.5


def test_nothing_jumps_at_a_frame_while_parts_bend(bust):
    frames = [bake_parts(bust, nodding(bust, d), VOXEL, HALF_WIDTH, SMALLEST) for d in (4.0, 8.0, 16.0)]
    points = skin(bust, nodding(bust, 8.0)).points * 1.01
    before, after = SdfSample.blank(len(points)), SdfSample.blank(len(points))
    build_collider_parts(frames[0], frames[1], 0.04).probe(points, 0.04, before)
    build_collider_parts(frames[1], frames[2], 0.04).probe(points, 0.0, after)
    assert np.allclose(before.distance, after.distance, atol=1e-6)


def test_a_pose_of_another_skeleton_is_refused(bust):
    with pytest.raises(BadInput, match="a pose of 1 joints"):
        bake_parts(bust, Pose(np.eye(4)[None], np.zeros((1, 4, 4))), VOXEL, HALF_WIDTH, SMALLEST)


def two_bones(palm: Mesh, *tips: Mesh) -> Body:
    """Skin that follows a bone and skin that follows its child."""
    points = np.concatenate([palm.points, *(tip.points for tip in tips)])
    firsts = np.cumsum([0, len(palm.points), *(len(tip.points) for tip in tips)])
    triangles = [mesh.triangles + first for mesh, first in zip((palm, *tips), firsts, strict=False)]
    skeleton = Skeleton(("palm", "tip"), np.array([-1, 0], np.int32), np.tile(np.eye(4), (2, 1, 1)), np.zeros((2, 3)))
    bones = (np.arange(len(points)) >= len(palm.points)).astype(np.int32)[:, None]
    return Body(Mesh(points, np.concatenate(triangles).astype(np.int32)), skeleton, bones, np.ones((len(points), 1)))


def test_a_part_that_is_too_thin_is_named(sphere):
    palm, knuckle, needle = sphere(0.1, level=3), sphere(0.03, (0.3, 0.0, 0.0), 3), sphere(1.0, level=3)
    thin = Mesh(needle.points * (0.1, 0.003, 0.003) + (0.5, 0.005, 0.005), needle.triangles)
    with pytest.warns(UserWarning, match="more than 5% of tip is too thin"):
        bake_parts(two_bones(palm, knuckle, thin), None, VOXEL, HALF_WIDTH, 0.0)
    with pytest.raises(BadInput, match=r"part tip: .* no sample .*smaller voxel.*larger `smallest`"):
        bake_parts(two_bones(palm, thin), None, VOXEL, HALF_WIDTH, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert bake_parts(two_bones(palm, thin), None, VOXEL, HALF_WIDTH, 10.0).names == ("palm",)


def test_a_part_is_as_fast_as_the_bones_that_move_in_it(sphere):
    body = two_bones(sphere(0.1, level=3), sphere(0.03, (0.3, 0.0, 0.0), 3))
    moved = body.skeleton.rest.copy()
    moved[1, 0, 3] = 2.0 / 24.0
    poses = [Pose(transforms, np.zeros((2, 4, 4))) for transforms in (body.skeleton.rest, moved)]
    one, same, other = (bake_parts(body, pose, VOXEL, HALF_WIDTH, 10.0) for pose in (*poses[:1], *poses))
    assert build_collider_parts(one, same, 1.0 / 24.0).speed == 0.0
    assert build_collider_parts(one, other, 1.0 / 24.0).speed == pytest.approx(2.0, rel=0.01)
    assert build_collider_parts(other, one, 1.0 / 24.0).speed == pytest.approx(2.0, rel=0.01)


def chain(sizes: list[float], parents: list[int]) -> Body:
    """Bones side by side, each with two vertices of skin a distance apart."""
    points = np.array([[10.0 * bone, y, 0.0] for bone, size in enumerate(sizes) for y in (0.0, size)])
    rest = np.tile(np.eye(4), (len(sizes), 1, 1))
    names = tuple(f"bone{bone}" for bone in range(len(sizes)))
    skeleton = Skeleton(names, np.array(parents, np.int32), rest, np.zeros((len(sizes), 3)))
    mesh = Mesh(points, np.zeros((0, 3), np.int32))
    return Body(mesh, skeleton, np.repeat(np.arange(len(sizes), dtype=np.int32), 2)[:, None], np.ones((len(points), 1)))


def test_large_bones_stay_alone_and_small_ones_join_their_parents():
    groups = group_bones(chain([1.0, 0.5, 0.01], [-1, 0, 1]), 0.2)
    assert groups.leaders.tolist() == [0, 1] and groups.members.tolist() == [0, 1, 1]


def test_joined_bones_count_for_the_size_of_a_group():
    # The tip alone is small; with the one that it joins it is large, being 10 m off.
    groups = group_bones(chain([1.0, 0.01, 0.01], [-1, 0, 1]), 0.2)
    assert groups.leaders.tolist() == [0, 1] and groups.members.tolist() == [0, 1, 1]


def test_bones_without_skin_join_whatever_is_small():
    body = chain([1.0, 1.0, 1.0], [-1, 0, 1])
    body = replace(body, joints=np.repeat(np.array([0, 0, 2], np.int32), 2)[:, None])
    assert group_bones(body, 0.0).members.tolist() == [0, 0, 1]


def test_root_without_neighbours_is_not_joined():
    assert group_bones(chain([0.01], [-1]), 0.2).leaders.tolist() == [0]


def test_all_weight_is_in_the_groups(bust):
    for smallest in (0.0, 0.18, 10.0):
        groups = group_bones(bust, smallest)
        weights = group_weights(bust, groups)
        assert weights.shape[1] == len(groups.leaders) and np.allclose(weights.sum(axis=1), 1.0)
    assert len(groups.leaders) == 1 and 3 <= len(group_bones(bust, 0.18).leaders) <= 4


def test_a_body_without_bones_is_one_group():
    empty = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))
    body = replace(chain([1.0], [-1]), skeleton=empty, joints=np.zeros((2, 0), np.int32), weights=np.zeros((2, 0)))
    groups = group_bones(body, 0.2)
    assert groups.leaders.tolist() == [-1] and np.array_equal(group_weights(body, groups), np.ones((2, 1)))
