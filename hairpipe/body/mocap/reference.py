"""The pose of a clip that is taken for the body's pose at rest, and the turns that make the two agree."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hairpipe.body.mocap.performer import Placement, place_at_zero, place_joints
from hairpipe.body.mocap.quaternion import shortest_turn
from hairpipe.body.mocap.roles import Role
from hairpipe.body.rigid import Z_UP
from hairpipe.data import Skeleton
from hairpipe.data.clip import Clip

Roles = dict[Role, list[int]]

UPRIGHT = 0.7  # cosine beyond which a performer counts as standing along an axis


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


def find_reference(clip: Clip, roles: Roles, up: str | None, reference: str | None) -> Reference:
    """Return the reference pose; axes and pose that are left open are told by how the performer stands. Pure.

    up         "y", "z", or None: Z where the all-zero pose stands along Z
    reference  "zero", "first", or None: all channels zero where that pose stands upright, else the first frame
    """
    zero = place_at_zero(clip)
    upward = standing_direction(zero.positions[0], roles)
    if up is None:
        up = "z" if upward[2] > UPRIGHT else "y"
    world = Z_UP if up == "z" else np.eye(3)
    drawn = reference == "zero" or (reference is None and bool((world @ upward)[1] > UPRIGHT))
    placement = turn(zero if drawn else place_joints(clip, np.zeros(1)), world)
    rotations, positions = placement.rotations[0], placement.positions[0]
    ends = positions + np.einsum("jab,jb->ja", rotations, np.nan_to_num(clip.ends))
    lowest = float(min(positions[:, 1].min(), ends[:, 1].min()))
    return Reference(world, find_heading(positions, roles), rotations, positions, lowest, drawn)


def turn(placement: Placement, world: np.ndarray) -> Placement:
    """Return joints turned as a whole by a rotation matrix (3, 3). Pure."""
    return Placement(world @ placement.rotations, placement.positions @ world.T)


def standing_direction(positions: np.ndarray, roles: Roles) -> np.ndarray:
    """Return the direction from feet over hips to head, shortened where they are not in line; Y where unknown. Pure."""
    joints = players(roles, Role("head"), Role("hips"), Role("foot", "left"), Role("foot", "right"))
    if joints is None:
        return np.array([0.0, 1.0, 0.0])
    head, hips, left, right = positions[joints]
    trunk, legs = head - hips, hips - 0.5 * (left + right)
    return (trunk + legs) / max(np.linalg.norm(trunk) + np.linalg.norm(legs), 1e-12)


def find_heading(positions: np.ndarray, roles: Roles) -> np.ndarray:
    """Return the turn about Y (3, 3) after which right thigh to left thigh, or arm to arm, points along it. Pure."""
    for part in ("thigh", "upperarm"):
        joints = players(roles, Role(part, "left"), Role(part, "right"))
        if joints is not None:
            across = positions[joints[0]] - positions[joints[1]]
            length = np.hypot(across[0], across[2])
            if length > 0.5 * np.linalg.norm(across):
                cosine, sine = across[0] / length, -across[2] / length
                return np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    return np.eye(3)


def players(roles: Roles, *parts: Role) -> list[int] | None:
    """Return the joint that plays each part, the first one of a chain, or None where a part is missing. Pure."""
    return [roles[part][0] for part in parts] if all(part in roles for part in parts) else None


LIMBS = (("upperarm", "forearm", "hand"), ("thigh", "shin", "foot"))


def align_parts(skeleton: Skeleton, body: Roles, clip: Roles, reference: Reference) -> dict[Role, np.ndarray]:
    """Return the turn (3, 3) of every part from the body's rest pose to the clip's reference pose. Pure.

    Both face +Z. Arms and legs take the smallest turn that lays bone on bone, after that of their parent: an A pose
    meets a T pose without twist. Hands go with forearms; feet with shins in a drawn pose, while in a recorded one they
    stand flat. Head and neck keep their directions, which clips draw too differently to be compared; so does a drawn
    trunk, while a recorded one leans as the performer did.
    """
    rest, seen = skeleton.rest[:, :3, 3], reference.positions @ reference.heading
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
    turns, current = {}, start
    for upper, lower in pairwise(limb):
        if all(role in roles for role in (upper, lower) for roles in (body, clip)):
            bone = current @ (rest[body[lower][0]] - rest[body[upper][0]])
            target = seen[clip[lower][0]] - seen[clip[upper][0]]
            if np.linalg.norm(bone) > 0.0 and np.linalg.norm(target) > 0.0:
                current = shortest_turn(bone, target) @ current
        turns[upper] = current
    return turns | {limb[-1]: current}
