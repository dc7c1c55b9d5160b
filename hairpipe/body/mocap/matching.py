"""Matching of the joints of a body with those of a clip, and the unmatched joints."""

import warnings
from difflib import get_close_matches
from itertools import product

import numpy as np

from hairpipe.body.mocap.roles import Role, match_roles
from hairpipe.data import Skeleton
from hairpipe.data.clip import Clip
from hairpipe.errors import BadInput

Roles = dict[Role, list[int]]
Pairs = tuple[tuple[str, str], ...]

LIMBS = (("upperarm", "forearm", "hand"), ("thigh", "shin", "foot"))
TRUNK = ("head", "neck", "spine", "hips")
WORDS = {"upperarm": "arm", "thigh": "leg", "spine": "trunk"}
"""The common name of a limb by its first part."""


def with_pairs(roles: Roles, body: Roles, skeleton: Skeleton, clip: Clip, joints: Pairs) -> Roles:
    """Return the roles of a clip's joints, with those that the user pairs with joints of the body. Pure.

    Raises BadInput where a joint does not exist.
    """
    parts = {joint: role for role, found in body.items() for joint in found}
    stated: Roles = {}
    for name, leader in joints:
        joint, followed = find_name(name, skeleton.names, "body"), find_name(leader, clip.names, "clip")
        if joint in parts:
            stated.setdefault(parts[joint], []).append(followed)
    return roles | stated


def match_joints(skeleton: Skeleton, clip: Clip, body: Roles, performer: Roles, joints: Pairs) -> np.ndarray:
    """Return the clip joint that every joint of the body follows, -1 for none, (J,). Pure.

    A limb follows where both its bones do: of one alone it is not known how the other lies. Raises BadInput where
    nothing matches.
    """
    follows = np.full(len(skeleton.names), -1)
    for joint, leader in match_roles(body, whole_limbs(body, performer)).items():
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


def whole_limbs(body: Roles, performer: Roles) -> Roles:
    """Return the roles of a performer without those of limbs of which a bone of the body has no counterpart. Pure."""
    partial = set()
    for limb, side in product(LIMBS, ("left", "right")):
        bones = [Role(part, side) for part in limb[:2]]
        if any(role in body and role not in performer for role in bones):
            partial |= {Role(part, side) for part in limb}
    return {role: joints for role, joints in performer.items() if role not in partial}


def find_name(name: str, names: tuple[str, ...], owner: str) -> int:
    """Return the index of a joint by its name; BadInput with near ones where there is none."""
    if name in names:
        return names.index(name)
    near = get_close_matches(name, names, n=3) or list(names[:8])
    raise BadInput(f"the {owner} has no joint {name!r}", where="joints", right=f"for example {', '.join(near)}")


def warn_of_losses(clip: Clip, body: Roles, follows: np.ndarray) -> None:
    """Warn of limbs of the body that follow nothing, and of joints of the clip that move nothing."""
    lost = [_name_of(role) for role in lost_limbs(body, follows)]
    if lost:
        message = f"no joint of the clip matches these parts of the body, which keep their rest pose: {', '.join(lost)}"
        warnings.warn(f"{message} (`joints` gives pairs of a joint of the body and a joint of the clip)", stacklevel=3)
    unused = [name for name, used in zip(clip.names, used_joints(clip, follows), strict=True) if not used]
    if unused:
        message = f"{len(unused)} of {len(clip.names)} joints of the clip are not used: {', '.join(unused)}"
        warnings.warn(message, stacklevel=3)


def used_joints(clip: Clip, follows: np.ndarray) -> np.ndarray:
    """Return which joints of a clip are followed, or carry one that is, (J,) bool. Pure."""
    used = np.isin(np.arange(len(clip.names)), follows)
    for joint in range(len(clip.names) - 1, -1, -1):
        if clip.parents[joint] >= 0:
            used[clip.parents[joint]] |= used[joint]
    return used


def lost_limbs(body: Roles, follows: np.ndarray) -> list[Role]:
    """Return the first part of every limb of a body that follows nothing, from there to its end. Pure."""
    chains = [(Role(part),) for part in TRUNK]
    chains += [tuple(Role(part, side) for part in limb) for limb in LIMBS for side in ("left", "right")]
    lost = ([role for role in chain if role in body and (follows[body[role]] < 0).all()] for chain in chains)
    return [found[0] for found in lost if found]


def _name_of(role: Role) -> str:
    return f"{role.side} {WORDS.get(role.part, role.part)}".strip()
