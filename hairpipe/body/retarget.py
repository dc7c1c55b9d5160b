"""A clip's motion carried over to a body of other proportions, rest pose and joint names.

Joints of body and clip are matched by their roles. A pose of the clip is taken for the body's pose at rest, and turns
make the two agree.
"""

import warnings
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from hairpipe.body.performer import Placement, local_positions, place_at_zero, place_joints
from hairpipe.body.roles import Role, find_roles, match_roles
from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import Z_UP, invert, shortest_turn
from hairpipe.values import Skeleton
from hairpipe.values.body import Clip

Roles = dict[Role, list[int]]
Pairs = tuple[tuple[str, str], ...]

LIMBS = (("upperarm", "forearm", "hand"), ("thigh", "shin", "foot"))
TRUNK = ("head", "neck", "spine", "hips")
WORDS = {"upperarm": "arm", "thigh": "leg", "spine": "trunk"}  # the common name of a limb by its first part


def match_joints(skeleton: Skeleton, clip: Clip, body: Roles, performer: Roles, joints: Pairs) -> np.ndarray:
    """Return the clip joint that every joint of the body follows, -1 for none, (J,); BadInput where nothing matches."""
    partial = set()
    for limb, side in product(LIMBS, ("left", "right")):  # of one bone alone it is not known how the other lies
        bones = [Role(part, side) for part in limb[:2]]
        if any(role in body and role not in performer for role in bones):
            partial |= {Role(part, side) for part in limb}
    follows = np.full(len(skeleton.names), -1)
    whole = {role: found for role, found in performer.items() if role not in partial}
    for joint, leader in match_roles(body, whole).items():
        follows[joint] = leader
    for name, leader in joints:
        follows[find_name(name, skeleton.names, "body")] = find_name(leader, clip.names, "clip")
    root = performer.get(Role("head" if len(follows) == 1 else "hips"))
    if root is not None:
        follows[(skeleton.parents < 0) & (follows < 0)] = root[0]
    if (follows < 0).all():
        names = ", ".join(clip.names[:8])
        raise BadInput(
            "no joint of the body matches one of the clip", where="joints", right=f'[["head", one of {names}, ...]]'
        )
    return follows


def find_name(name: str, names: tuple[str, ...], owner: str) -> int:
    """Return the index of a joint by its name; BadInput with near ones where there is none."""
    if name in names:
        return names.index(name)
    near = get_close_matches(name, names, n=3) or list(names[:8])
    raise BadInput(f"the {owner} has no joint {name!r}", where="joints", right=f"for example {', '.join(near)}")


def warn_of_losses(clip: Clip, body: Roles, follows: np.ndarray) -> None:
    """Warn of limbs of the body that follow nothing, and of joints of the clip that move nothing."""
    chains = [(Role(part),) for part in TRUNK]
    chains += [tuple(Role(part, side) for part in limb) for limb in LIMBS for side in ("left", "right")]
    ends = ([role for role in chain if role in body and (follows[body[role]] < 0).all()] for chain in chains)
    lost = [f"{end[0].side} {WORDS.get(end[0].part, end[0].part)}".strip() for end in ends if end]
    if lost:
        message = f"no joint of the clip matches these parts of the body, which keep their rest pose: {', '.join(lost)}"
        warnings.warn(f"{message} (`joints` gives pairs of a joint of the body and a joint of the clip)", stacklevel=3)
    used = np.isin(np.arange(len(clip.names)), follows)
    for joint in range(len(clip.names) - 1, -1, -1):  # A parent of a used joint is used.
        if clip.parents[joint] >= 0:
            used[clip.parents[joint]] |= used[joint]
    unused = [clip.names[joint] for joint in np.flatnonzero(~used)]
    if unused:
        message = f"{len(unused)} of {len(clip.names)} joints of the clip are not used: {', '.join(unused)}"
        warnings.warn(message, stacklevel=3)


UPRIGHT = 0.7  # cosine beyond which a performer counts as standing along an axis
LOOKS = 100
"""Frames of a clip that are looked at, spread evenly."""
LEAST = 0.3  # length of a median of unit directions, below which they have none in common
TINY = 1e-12


class Reference(NamedTuple):
    """The joints of a clip in its reference pose, Y up."""

    world: np.ndarray  # takes the file's axes to Y up, (3, 3)
    heading: np.ndarray  # turn about Y from facing +Z to facing as the performer does, (3, 3)
    rotations: np.ndarray  # joint-to-world, (J, 3, 3)
    positions: np.ndarray  # [file units], (J, 3)
    lowest: float  # height of the lowest joint or End Site [file units]
    drawn: bool  # whether it is a drawn pose (all channels zero), not a recorded one


def find_reference(clip: Clip, roles: Roles, up: str | None, reference: str | None, yaw: float = 0.0) -> Reference:
    """Return the reference pose; missing axes and poses are derived from the stance of the performer.

    Without `reference` it is that of all channels zero where this stands upright, else the first frame; yaw [deg] is a
    turn of the whole motion about Y.
    """
    zero = place_at_zero(clip)
    upright = Z_UP if (up or find_up(clip, roles)) == "z" else np.eye(3)
    cosine = np.cos(np.radians(yaw))
    sine = np.sin(np.radians(yaw))
    world = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]]) @ upright
    stands = standing_direction(zero.positions[0], roles)
    drawn = reference == "zero" or (reference is None and bool((world @ stands)[1] > UPRIGHT))
    placement = turn(zero if drawn else place_joints(clip, np.zeros(1)), world)
    rotations, positions = placement.rotations[0], placement.positions[0]
    ends = positions + np.einsum("jab,jb->ja", rotations, np.nan_to_num(clip.ends))
    lowest = float(min(positions[:, 1].min(), ends[:, 1].min()))
    return Reference(world, find_heading(positions, roles), rotations, positions, lowest, drawn)


def turn(placement: Placement, world: np.ndarray) -> Placement:
    """Return joints turned as a whole by a rotation matrix (3, 3)."""
    return Placement(world @ placement.rotations, placement.positions @ world.T, placement.local)


def find_up(clip: Clip, roles: Roles) -> str:
    """Return the axis, "y" or "z", of the median direction of the trunk over LOOKS frames; Y where it is unknown.

    Warns where there is no trunk, where it lies, so that the pose with all channels zero decides, and where it stands
    along the other axis in that pose.
    """
    frames = np.unique(np.linspace(0.0, len(clip.values) - 1, LOOKS).round())
    motion = _axis_along(np.median(trunk_directions(place_joints(clip, frames).positions, roles), axis=0))
    rest = _axis_along(trunk_directions(place_at_zero(clip).positions, roles)[0])
    axis = motion or rest or "y"
    stated = "(`up` states it)"
    if motion is None:
        what = "the clip has no trunk that is upright in most frames"
        warnings.warn(f"{what}: {axis.upper()} is assumed as the vertical axis {stated}", stacklevel=4)
    elif rest not in (None, motion):
        what = f"the trunk of the clip is along {rest.upper()} at rest, along {motion.upper()} in most of the motion"
        warnings.warn(f"{what}: {axis.upper()} is assumed as the vertical axis {stated}", stacklevel=4)
    return axis


def _axis_along(direction: np.ndarray) -> str | None:
    length = np.linalg.norm(direction)
    along = (axis for axis, share in zip("yz", direction[1:], strict=True) if share > UPRIGHT * length)
    return next(along, None) if length > LEAST else None


def trunk_directions(positions: np.ndarray, roles: Roles) -> np.ndarray:
    """Return the unit direction of the trunk of joints (k, J, 3), hips to head or next below it, (k, 3); 0 if none."""
    chain = [joint for part in ("hips", "spine", "neck", "head") for joint in roles.get(Role(part), [])]
    arms = players(roles, Role("upperarm", "left"), Role("upperarm", "right"))
    ends = [positions[:, chain[0]]] if chain else []
    ends += [positions[:, chain[-1]]] if len(chain) > 1 else []
    ends += [positions[:, arms].mean(axis=1)] if len(ends) == 1 and arms is not None else []
    if len(ends) < 2:
        return np.zeros((len(positions), 3))
    ways = ends[1] - ends[0]
    return ways / np.maximum(np.linalg.norm(ways, axis=1), TINY)[:, None]


def standing_direction(positions: np.ndarray, roles: Roles) -> np.ndarray:
    """Return the direction from feet over hips to head, shortened where they are not in line, or of the trunk, or Y."""
    joints = players(roles, Role("head"), Role("hips"), Role("foot", "left"), Role("foot", "right"))
    if joints is None:
        trunk = trunk_directions(positions[None], roles)[0]
        return trunk if trunk.any() else np.array([0.0, 1.0, 0.0])
    head, hips, left, right = positions[joints]
    trunk = head - hips
    legs = hips - 0.5 * (left + right)
    return (trunk + legs) / max(np.linalg.norm(trunk) + np.linalg.norm(legs), TINY)


def find_heading(positions: np.ndarray, roles: Roles) -> np.ndarray:
    """Return the turn about Y (3, 3) after which right thigh to left thigh, or arm to arm, points along it."""
    for part in ("thigh", "upperarm"):
        joints = players(roles, Role(part, "left"), Role(part, "right"))
        if joints is not None:
            across = positions[joints[0]] - positions[joints[1]]
            length = np.hypot(across[0], across[2])
            if length > 0.5 * np.linalg.norm(across):
                cosine = across[0] / length
                sine = -across[2] / length
                return np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    return np.eye(3)


def players(roles: Roles, *parts: Role) -> list[int] | None:
    """Return the joint that plays each part, the first one of a chain, or None where a part is missing."""
    return [roles[part][0] for part in parts] if all(part in roles for part in parts) else None


def align_parts(rest: np.ndarray, body: Roles, clip: Roles, reference: Reference) -> dict[Role, np.ndarray]:
    """Return the turn (3, 3) of every part from the body's rest pose, (J, 3), to the clip's reference pose.

    Both face +Z. Arms and legs take the smallest turn that lays bone on bone, after that of their parent: an A pose
    meets a T pose without twist. Hands go with forearms; feet with shins in a drawn pose, while in a recorded one they
    stand flat. Head and neck keep their directions, which clips draw too differently to be compared; so does a drawn
    trunk, while a recorded one leans as the performer did.
    """
    seen = reference.positions @ reference.heading

    def bones(lower: Role, upper: Role) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the way from one joint to the other, of the body and of the clip, where both have them."""
        if not all(role in roles for role in (lower, upper) for roles in (body, clip)):
            return None
        return rest[body[upper][0]] - rest[body[lower][0]], seen[clip[upper][0]] - seen[clip[lower][0]]

    spine = bones(Role("hips"), Role("neck"))
    trunk = np.eye(3) if reference.drawn or spine is None else shortest_turn(*spine)
    turns = {role: trunk for role in body if role.part in ("hips", "spine", "clavicle")}
    for side in ("left", "right"):
        for limb in LIMBS:
            current = trunk
            parts = [Role(part, side) for part in limb]
            for near, far in pairwise(parts):
                both = bones(near, far)
                if both is not None:
                    bone = current @ both[0]
                    if np.linalg.norm(bone) > 0.0 and np.linalg.norm(both[1]) > 0.0:
                        current = shortest_turn(bone, both[1]) @ current
                turns[near] = current
            turns[parts[-1]] = current
        if not reference.drawn:
            turns[Role("foot", side)] = np.eye(3)
    return turns


ADULT_LEG = 0.82  # hip to ankle [m]: what a clip is scaled to where the body has no legs to compare with


@dataclass(frozen=True)
class Retarget:
    """Retargeting of the joints of a clip to those of a skeleton."""

    skeleton: Skeleton
    follows: np.ndarray  # joint of the clip that every joint of the body follows, -1: its parent, (J,)
    corrections: np.ndarray  # factors of the rotation of the clip's joint from the right, (J, 3, 3)
    scale: float  # metres in a unit of the clip
    origins: np.ndarray  # of every followed joint in the clip where the body is at rest [clip units], (J, 3)
    world: np.ndarray  # takes the clip's axes to Y up, (3, 3)
    bones: np.ndarray  # every joint of the clip in its parent in the first frame [clip units], (K, 3)
    stretches: tuple[tuple[int, ...], ...]  # joints whose way in their parents moves each joint of the body on

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
                way = np.zeros((len(frames), 3))
                for moved in self.stretches[joint]:
                    above = placement.rotations[:, clip.parents[moved]]
                    way += np.einsum("kij,kj->ki", above, placement.local[:, moved] - self.bones[moved])
                result[:, joint, :3, 3] += self.scale * way
            elif leader >= 0:
                moved = placement.positions[:, leader] - self.origins[joint]
                result[:, joint, :3, 3] = rest[joint, :3, 3] + self.scale * moved
            if leader >= 0:
                result[:, joint, :3, :3] = placement.rotations[:, leader] @ self.corrections[joint]
        return result


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
    """Match joints, find the clip's reference pose, see `find_reference`, and its unit [m], see `find_scale`. Pure.

    joints  pairs of a joint of the body and the joint of the clip it follows, where the names do not tell

    Raises BadInput where a joint does not exist or none match; warns of what has no counterpart.
    """
    body = find_roles(skeleton.names)
    parts = {joint: role for role, found in body.items() for joint in found}
    paired: Roles = {}
    for name, leader in joints:
        joint, followed = find_name(name, skeleton.names, "body"), find_name(leader, clip.names, "clip")
        if joint in parts:
            paired.setdefault(parts[joint], []).append(followed)
    performer = find_roles(clip.names) | paired
    pose = find_reference(clip, performer, up, reference, yaw)
    follows = match_joints(skeleton, clip, body, performer, joints)
    warn_of_losses(clip, body, follows)
    facing = body_heading(skeleton, body)
    turns = align_parts(skeleton.rest[:, :3, 3] @ facing, body, performer, pose)
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
    """Return the turn about Y (3, 3) from facing +Z to facing as the body does at rest; none up to 45 degrees."""
    heading = find_heading(skeleton.rest[:, :3, 3], body)
    if heading[0, 0] > np.sqrt(0.5):
        return np.eye(3)
    angle = np.degrees(np.arctan2(heading[0, 2], heading[0, 0]))
    message = f"at rest the body faces {angle:.0f} degrees from +Z about Y, by its left and right"
    warnings.warn(f"{message}: the clip is applied as to a body that faces +Z", stacklevel=3)
    return heading


def find_stretches(skeleton: Skeleton, clip: Clip, follows: np.ndarray) -> tuple[tuple[int, ...], ...]:
    """Return the joints of the clip with position channels between every joint of the body and what is above it.

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
    """Return the metres in a unit of the clip: leg to leg, or to an adult's leg, or from root to head, or 1."""
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
    """Return the length of thigh and shin, the mean of both legs; 0 without legs."""
    lengths = []
    for side in ("left", "right"):
        leg = players(roles, *(Role(part, side) for part in ("thigh", "shin", "foot")))
        if leg is not None:
            lengths.append(np.linalg.norm(np.diff(positions[leg], axis=0), axis=1).sum())
    return float(np.mean(lengths)) if lengths else 0.0


def find_origins(
    skeleton: Skeleton, follows: np.ndarray, body: Roles, performer: Roles, pose: Reference, scale: float
) -> np.ndarray:
    """Return where in the clip every followed joint is when the body is at rest [clip units], (J, 3).

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
