"""A clip's motion carried over to a body of other proportions, rest pose and joint names."""

import warnings
from dataclasses import dataclass

import numpy as np

from hairpipe.body.mocap.matching import Pairs, Roles, match_joints, warn_of_losses, with_pairs
from hairpipe.body.mocap.performer import Placement, local_positions, place_joints
from hairpipe.body.mocap.reference import Reference, align_parts, find_heading, find_reference, players, turn
from hairpipe.body.mocap.roles import Role, find_roles
from hairpipe.body.rigid import invert
from hairpipe.data import Skeleton
from hairpipe.data.clip import Clip

ADULT_LEG = 0.82  # hip to ankle [m]: what a clip is scaled to where the body has no legs to compare with


@dataclass(frozen=True)
class Retarget:
    """Retargeting of the joints of a clip to those of a skeleton.

    follows      joint of the clip that every joint of the body follows, -1 where it follows its parent, (J,)
    corrections  to be multiplied to the rotation of the clip's joint from the right, (J, 3, 3)
    scale        metres in a unit of the clip
    origins      position of every followed joint in the clip that stands for the body's at rest [clip units], (J, 3)
    world        takes the clip's axes to Y up, (3, 3)
    bones        position of every joint of the clip in its parent in its first frame [clip units], (K, 3)
    stretches    joints of the clip by whose way in their parents every joint of the body is moved on
    """

    skeleton: Skeleton
    follows: np.ndarray
    corrections: np.ndarray
    scale: float
    origins: np.ndarray
    world: np.ndarray
    bones: np.ndarray
    stretches: tuple[tuple[int, ...], ...]

    def transforms(self, clip: Clip, frames: np.ndarray) -> np.ndarray:
        """Return the joint-to-world matrices of the body [m] at fractional frames (k,) of the clip, (k, J, 4, 4). Pure.

        A joint b that follows c turns as R_b(t) = R_c(t) R_c(ref)^T A_b R_b(rest), A_b from `align_parts`; bones keep
        their length, and are stretched and moved as those of the clip are since its first frame; a root moves by the
        scaled motion of the joint it follows.
        """
        placement = turn(place_joints(clip, frames), self.world)
        rest, parents = self.skeleton.rest, self.skeleton.parents
        result = np.tile(rest, (len(frames), 1, 1, 1))
        for joint, (parent, leader) in enumerate(zip(parents, self.follows, strict=True)):
            if parent >= 0:
                result[:, joint] = result[:, parent] @ invert(rest[parent]) @ rest[joint]
                result[:, joint, :3, 3] += self.scale * self._way(clip, placement, joint)
            elif leader >= 0:
                moved = placement.positions[:, leader] - self.origins[joint]
                result[:, joint, :3, 3] = rest[joint, :3, 3] + self.scale * moved
            if leader >= 0:
                result[:, joint, :3, :3] = placement.rotations[:, leader] @ self.corrections[joint]
        return result

    def _way(self, clip: Clip, placement: Placement, joint: int) -> np.ndarray:
        """Return how far the channels of the clip move a joint of the body against its parent [clip units], (k, 3)."""
        way = np.zeros((len(placement.local), 3))
        for moved in self.stretches[joint]:
            above = placement.rotations[:, clip.parents[moved]]
            way += np.einsum("kij,kj->ki", above, placement.local[:, moved] - self.bones[moved])
        return way


def build_retarget(
    skeleton: Skeleton,
    clip: Clip,
    *,
    up: str | None,
    reference: str | None,
    unit: float | None,
    joints: Pairs,
    yaw: float = 0.0,
) -> Retarget:
    """Match joints, find the clip's reference pose and its scale. Pure.

    up, reference, yaw  see `find_reference`
    unit                of the clip [m]; None: see `find_scale`
    joints              pairs of a joint of the body and the joint of the clip it follows, where the names do not tell

    Raises BadInput where a joint does not exist or none match; warns of what has no counterpart.
    """
    body = find_roles(skeleton.names)
    performer = with_pairs(find_roles(clip.names), body, skeleton, clip, joints)
    pose = find_reference(clip, performer, up, reference, yaw)
    follows = match_joints(skeleton, clip, body, performer, joints)
    warn_of_losses(clip, body, follows)
    facing = body_heading(skeleton, body)
    turns = align_parts(skeleton.rest[:, :3, 3] @ facing, body, performer, pose)
    parts = {joint: role for role, found in body.items() for joint in found}
    corrections = np.tile(np.eye(3), (len(follows), 1, 1))
    for joint in np.flatnonzero(follows >= 0):
        part = parts.get(int(joint), Role(""))
        aligned = pose.heading @ turns.get(part, np.eye(3)) @ facing.T @ skeleton.rest[joint, :3, :3]
        corrections[joint] = pose.rotations[follows[joint]].T @ aligned
    scale = unit if unit is not None else find_scale(skeleton, follows, body, performer, pose)
    origins = find_origins(skeleton, follows, body, performer, pose, scale)
    bones = local_positions(clip, np.zeros(1, np.int64))[0]
    stretches = find_stretches(skeleton, clip, follows)
    return Retarget(skeleton, follows, corrections, scale, origins, pose.world, bones, stretches)


def body_heading(skeleton: Skeleton, body: Roles) -> np.ndarray:
    """Return the turn about Y (3, 3) from facing +Z to facing as the body does at rest; none up to 45 degrees. Pure."""
    heading = find_heading(skeleton.rest[:, :3, 3], body)
    if heading[0, 0] > np.sqrt(0.5):
        return np.eye(3)
    angle = np.degrees(np.arctan2(heading[0, 2], heading[0, 0]))
    message = f"at rest the body faces {angle:.0f} degrees from +Z about Y, by its left and right"
    warnings.warn(f"{message}: the clip is applied as to a body that faces +Z", stacklevel=3)
    return heading


def find_stretches(skeleton: Skeleton, clip: Clip, follows: np.ndarray) -> tuple[tuple[int, ...], ...]:
    """Return the joints of the clip with position channels between every joint of the body and what is above it. Pure.

    They go from the joint that is followed up to the one that the closest joint above it follows; none of a root, which
    has the whole way of its joint.
    """
    moved = [any(name.endswith("position") for name in names) for names in clip.channels]
    above = np.full(len(follows), -1)
    stretches = []
    for joint, (parent, leader) in enumerate(zip(skeleton.parents, follows, strict=True)):
        above[joint] = leader if leader >= 0 or parent < 0 else above[parent]
        path = []
        end = above[parent] if parent >= 0 else leader
        while parent >= 0 and leader >= 0 and leader != end and clip.parents[leader] >= 0:
            path += [leader] if moved[leader] else []
            leader = clip.parents[leader]
        stretches.append(tuple(path))
    return tuple(stretches)


def find_scale(skeleton: Skeleton, follows: np.ndarray, body: Roles, performer: Roles, pose: Reference) -> float:
    """Return the metres in a unit of the clip: leg to leg, or to an adult's leg, or from root to head. Pure.

    Where joints tell none of these it is a metre, with a warning if a root moves by it.
    """
    rest = skeleton.rest[:, :3, 3]
    own = leg_length(rest, body)
    theirs = leg_length(pose.positions, performer)
    if theirs > 0.0:
        return (own or ADULT_LEG) / theirs
    way = [int(np.argmax(skeleton.parents < 0)), *(players(body, Role("head")) or [])]
    if len(way) == 2 and (follows[way] >= 0).all():
        own = np.linalg.norm(np.diff(rest[way], axis=0))
        theirs = np.linalg.norm(np.diff(pose.positions[follows[way]], axis=0))
        if own > 0.0 and theirs > 0.0:
            return float(own / theirs)
    if (follows[skeleton.parents < 0] >= 0).any():
        warnings.warn("unknown unit of the clip: metres are assumed (`unit` states it)", stacklevel=2)
    return 1.0


def leg_length(positions: np.ndarray, roles: Roles) -> float:
    """Return the length of thigh and shin, the mean of both legs; 0 without legs. Pure."""
    lengths = []
    for side in ("left", "right"):
        leg = players(roles, *(Role(part, side) for part in ("thigh", "shin", "foot")))
        if leg is not None:
            lengths.append(np.linalg.norm(np.diff(positions[leg], axis=0), axis=1).sum())
    return float(np.mean(lengths)) if lengths else 0.0


def find_origins(
    skeleton: Skeleton, follows: np.ndarray, body: Roles, performer: Roles, pose: Reference, scale: float
) -> np.ndarray:
    """Return where in the clip every followed joint is when the body is at rest [clip units], (J, 3). Pure.

    A performer with legs stands over the clip's origin, on its floor y = 0; as high as the body does, if that has legs.
    Without legs, it is the reference pose as it is.
    """
    origins = pose.positions[follows]
    joints = players(performer, Role("hips"))
    if joints is None or leg_length(pose.positions, performer) == 0.0:
        return origins
    hips = joints[0]
    origins = origins - pose.positions[hips] * (1.0, 0.0, 1.0)
    height = -pose.lowest
    if leg_length(skeleton.rest[:, :3, 3], body) > 0.0 and Role("hips") in body:
        rest = skeleton.rest[:, 1, 3]
        height = (rest[body[Role("hips")][0]] - skeleton.tips[:, 1].min()) / scale - pose.positions[hips][1]
    return origins + np.array([0.0, height, 0.0])
