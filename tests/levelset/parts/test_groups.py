"""Bones that move as one."""

from dataclasses import replace

import numpy as np

from hairpipe.body.bust import build_bust
from hairpipe.levelset.bake_parts import group_bones, group_weights
from hairpipe.values import Body, Mesh, Skeleton


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


def test_all_weight_is_in_the_groups():
    body = build_bust()
    for smallest in (0.0, 0.18, 10.0):
        groups = group_bones(body, smallest)
        weights = group_weights(body, groups)
        assert weights.shape[1] == len(groups.leaders) and np.allclose(weights.sum(axis=1), 1.0)
    assert len(groups.leaders) == 1 and 3 <= len(group_bones(body, 0.18).leaders) <= 4


def test_a_body_without_bones_is_one_group():
    empty = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))
    body = replace(chain([1.0], [-1]), skeleton=empty, joints=np.zeros((2, 0), np.int32), weights=np.zeros((2, 0)))
    groups = group_bones(body, 0.2)
    assert groups.leaders.tolist() == [-1] and np.array_equal(group_weights(body, groups), np.ones((2, 1)))
