"""The pose of a clip that is taken for the body's pose at rest, and the turns that make the two agree."""

import warnings
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hairpipe.body.mocap.matching import LIMBS, Roles
from hairpipe.body.mocap.performer import Placement, place_at_zero, place_joints
from hairpipe.body.mocap.quaternion import shortest_turn
from hairpipe.body.mocap.roles import Role
from hairpipe.body.rigid import Z_UP
from hairpipe.data.clip import Clip

UPRIGHT = 0.7  # cosine beyond which a performer counts as standing along an axis
LOOKS = 100
"""Frames of a clip that are looked at, spread evenly."""
LEAST = 0.3  # length of a median of unit directions, below which they have none in common
TINY = 1e-12


class Reference(NamedTuple):
    """The joints of a clip in its reference pose, Y up.

    world      takes the file's axes to Y up (3, 3)
    heading    turn about Y from facing +Z to facing as the performer does (3, 3)
    rotations  joint-to-world (J, 3, 3)
    positions  [file units] (J, 3)
    lowest     height of the lowest joint or End Site [file units]
    drawn      whether it is a drawn pose (all channels zero), not a recorded one
    """

    world: np.ndarray
    heading: np.ndarray
    rotations: np.ndarray
    positions: np.ndarray
    lowest: float
    drawn: bool


def find_reference(clip: Clip, roles: Roles, up: str | None, reference: str | None, yaw: float = 0.0) -> Reference:
    """Return the reference pose; missing axes and poses are derived from the stance of the performer. Pure.

    up         "y", "z", or None: see `find_up`
    reference  "zero", "first", or None: all channels zero where that pose stands upright, else the first frame
    yaw        turn of the whole motion about Y [deg]
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
    """Return joints turned as a whole by a rotation matrix (3, 3). Pure."""
    return Placement(world @ placement.rotations, placement.positions @ world.T, placement.local)


def find_up(clip: Clip, roles: Roles) -> str:
    """Return the axis, "y" or "z", that the trunk points along in most of the motion; Y where it is unknown.

    It is that of the median direction over LOOKS frames of the clip. Warns where there is no trunk, where it lies, so
    that the pose with all channels zero decides, and where it stands along the other axis in that pose.
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
    """Return the unit direction of the trunk, hips to head or next below it, (k, 3); 0 if unknown. Pure.

    positions  of joints, (k, J, 3)
    """
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
    """Return the direction from feet over hips to head, shortened where they are not in line. Pure.

    Of a performer without feet or head it is that of the trunk, and Y where that is unknown.
    """
    joints = players(roles, Role("head"), Role("hips"), Role("foot", "left"), Role("foot", "right"))
    if joints is None:
        trunk = trunk_directions(positions[None], roles)[0]
        return trunk if trunk.any() else np.array([0.0, 1.0, 0.0])
    head, hips, left, right = positions[joints]
    trunk = head - hips
    legs = hips - 0.5 * (left + right)
    return (trunk + legs) / max(np.linalg.norm(trunk) + np.linalg.norm(legs), TINY)


def find_heading(positions: np.ndarray, roles: Roles) -> np.ndarray:
    """Return the turn about Y (3, 3) after which right thigh to left thigh, or arm to arm, points along it. Pure."""
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
    """Return the joint that plays each part, the first one of a chain, or None where a part is missing. Pure."""
    return [roles[part][0] for part in parts] if all(part in roles for part in parts) else None


def align_parts(rest: np.ndarray, body: Roles, clip: Roles, reference: Reference) -> dict[Role, np.ndarray]:
    """Return the turn (3, 3) of every part from the body's rest pose to the clip's reference pose. Pure.

    rest  places of the body's joints [m], (J, 3)

    Both face +Z. Arms and legs take the smallest turn that lays bone on bone, after that of their parent: an A pose
    meets a T pose without twist. Hands go with forearms; feet with shins in a drawn pose, while in a recorded one they
    stand flat. Head and neck keep their directions, which clips draw too differently to be compared; so does a drawn
    trunk, while a recorded one leans as the performer did.
    """
    seen = reference.positions @ reference.heading
    trunk = np.eye(3)
    ends = Role("hips"), Role("neck")
    if not reference.drawn and all(role in roles for role in ends for roles in (body, clip)):
        lower, upper = ends
        trunk = shortest_turn(rest[body[upper][0]] - rest[body[lower][0]], seen[clip[upper][0]] - seen[clip[lower][0]])
    turns = {role: trunk for role in body if role.part in ("hips", "spine", "clavicle")}
    for side in ("left", "right"):
        for limb in LIMBS:
            turns |= _align_limb([Role(part, side) for part in limb], rest, seen, body, clip, trunk)
        if not reference.drawn:
            turns[Role("foot", side)] = np.eye(3)
    return turns


def _align_limb(
    limb: list[Role], rest: np.ndarray, seen: np.ndarray, body: Roles, clip: Roles, start: np.ndarray
) -> dict[Role, np.ndarray]:
    turns = {}
    current = start
    for upper, lower in pairwise(limb):
        if all(role in roles for role in (upper, lower) for roles in (body, clip)):
            bone = current @ (rest[body[lower][0]] - rest[body[upper][0]])
            target = seen[clip[lower][0]] - seen[clip[upper][0]]
            if np.linalg.norm(bone) > 0.0 and np.linalg.norm(target) > 0.0:
                current = shortest_turn(bone, target) @ current
        turns[upper] = current
    return turns | {limb[-1]: current}
