"""Bones that move as one: the joints of a skeleton in a few groups, small ones with their parents."""

from typing import NamedTuple

import numpy as np

from hairpipe.values import Body


class Groups(NamedTuple):
    leaders: np.ndarray  # joint whose frame each group has, (G,) int32
    members: np.ndarray  # group of every joint, (J,) int32


def group_bones(body: Body, smallest: float) -> Groups:
    """Return the groups that the joints of a body fall into; pure.

    smallest  diagonal of the box around the skin that follows a group more than any other joint [m]; a group whose skin
              is smaller than that joins its parent's, from the finger tips inwards

    Joints without skin join likewise. A body without joints is one group, whose leader is -1.
    """
    parents = body.skeleton.parents
    if not len(parents):
        return Groups(np.array([-1], np.int32), np.zeros(0, np.int32))
    leader = np.arange(len(parents), dtype=np.int32)
    strongest = np.argmax(body.weights, axis=1)  # of equal ones the first
    nearest = np.take_along_axis(body.joints, strongest[:, None], axis=1)[:, 0]
    for joint in range(len(parents) - 1, -1, -1):
        skin = body.mesh.points[leader[nearest] == joint]
        small = not len(skin) or np.linalg.norm(np.ptp(skin, axis=0)) < smallest
        if parents[joint] >= 0 and small:
            leader[leader == joint] = parents[joint]
    leaders, members = np.unique(leader, return_inverse=True)
    return Groups(leaders.astype(np.int32), members.astype(np.int32))


def group_weights(body: Body, groups: Groups) -> np.ndarray:
    """Return the weight of every vertex in every group, (n, G) float64; pure."""
    weights = np.zeros((len(body.mesh.points), len(groups.leaders)))
    if not len(groups.members):
        return weights + 1.0
    rows = np.arange(len(weights))
    for joints, shares in zip(body.joints.T, body.weights.T, strict=True):
        np.add.at(weights, (rows, groups.members[joints]), shares)
    return weights
