"""Height of the standing feet of a posed body above the floor of the body at rest."""

import numpy as np

from hairpipe.body.mocap.reference import LOOKS
from hairpipe.body.mocap.retarget import Retarget
from hairpipe.body.mocap.roles import Role, find_roles
from hairpipe.body.rigid import invert
from hairpipe.data import Skeleton
from hairpipe.data.clip import Clip

RESTING = 0.25  # [m/s] slower than this, the lower foot stands


def standing_height(retarget: Retarget, clip: Clip) -> float | None:
    """Return the height of the feet above the floor of the body at rest [m], negative below it. Pure.

    That is the median of the lower foot's height over the frames in which it rests; None where the body has no feet, or
    they rest in less than a tenth of the frames.
    """
    feet = feet_of(retarget.skeleton)
    if not feet:
        return None
    frames = np.unique(np.linspace(0.0, len(clip.values) - 1, LOOKS).round())
    step = min(1.0, len(clip.values) - 1.0)
    early = retarget.transforms(clip, np.minimum(frames, len(clip.values) - 1 - step))
    late = retarget.transforms(clip, np.minimum(frames + 1.0, len(clip.values) - 1.0))
    found = [soles(retarget.skeleton, foot, early, late, clip.frame_time) for foot in feet]
    heights, speeds = np.stack([height for height, _ in found]), np.stack([speed for _, speed in found])
    lower = heights.argmin(axis=0)[None]
    height, speed = (np.take_along_axis(rows, lower, axis=0)[0] for rows in (heights, speeds))
    rests = speed < RESTING
    return float(np.median(height[rests])) if rests.mean() >= 0.1 else None


def feet_of(skeleton: Skeleton) -> list[np.ndarray]:
    """Return the joints of every foot, toes included, as masks (J,) bool."""
    roles = find_roles(skeleton.names)
    found = []
    for side in ("left", "right"):
        for joint in roles.get(Role("foot", side), []):
            below = np.zeros(len(skeleton.names), bool)
            below[joint] = True
            for child, parent in enumerate(skeleton.parents):
                below[child] |= parent >= 0 and below[parent]
            found.append(below)
    return found


def soles(
    skeleton: Skeleton, foot: np.ndarray, early: np.ndarray, late: np.ndarray, frame_time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the height of a foot over its place at rest [m], (k,), and the speed of its lowest point [m/s], (k,).

    early, late  joint-to-world matrices [m] at k instants and a frame later, (k, J, 4, 4)
    """
    local = np.concatenate([np.tile([0.0, 0.0, 0.0, 1.0], (foot.sum(), 1)), tips_within(skeleton)[foot]])
    joints = np.tile(np.flatnonzero(foot), 2)
    here, there = (np.einsum("kjab,jb->kja", moves[:, joints], local)[..., :3] for moves in (early, late))
    rest = min(skeleton.rest[foot, 1, 3].min(), skeleton.tips[foot, 1].min())
    lowest = here[..., 1].argmin(axis=1)[:, None]
    speeds = np.linalg.norm(there - here, axis=2) / frame_time
    heights = np.take_along_axis(here[..., 1], lowest, axis=1) - rest
    return heights[:, 0], np.take_along_axis(speeds, lowest, axis=1)[:, 0]


def tips_within(skeleton: Skeleton) -> np.ndarray:
    """Return the far ends of all bones in the frames of their joints [m], (J, 4), homogeneous."""
    tips = np.concatenate([skeleton.tips, np.ones((len(skeleton.tips), 1))], axis=1)
    return np.einsum("jab,jb->ja", invert(skeleton.rest), tips)
