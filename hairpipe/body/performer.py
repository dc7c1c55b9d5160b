"""The joints of a clip in space: its channels sampled at any time, then chained from parent to child."""

import math
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from hairpipe.values.body import Clip

AXES = {"X": 0, "Y": 1, "Z": 2}


class Placement(NamedTuple):
    """Positions and rotations of joints at k instants."""

    rotations: np.ndarray  # joint-to-world (k, J, 3, 3)
    positions: np.ndarray  # in the units of the clip (k, J, 3)
    local: np.ndarray  # the same in their parents (k, J, 3)


def place_joints(clip: Clip, frames: np.ndarray) -> Placement:
    """Return the joints at fractional frames (k,) of a clip. Pure.

    Between frames local rotations turn along great arcs and local positions move straight; beyond the ends they go on
    as between the two frames there.
    """
    before = np.clip(frames.astype(np.int64), 0, max(len(clip.values) - 2, 0))
    after = np.minimum(before + 1, len(clip.values) - 1)
    share = (frames - before)[:, None, None]
    turns = local_turns(clip, before)
    ways = (turns.inv() * local_turns(clip, after)).as_rotvec()  # of half a turn at the most
    turns = turns * Rotation.from_rotvec(np.repeat(share[:, 0], len(clip.names), axis=0) * ways)
    start, end = local_positions(clip, before), local_positions(clip, after)
    return chain(clip.parents, turns.as_matrix().reshape(*start.shape, 3), start + share * (end - start))


def place_at_zero(clip: Clip) -> Placement:
    """Return the joints where all channels are zero and roots stand at their offsets, k = 1. Pure."""
    return chain(clip.parents, np.tile(np.eye(3), (1, len(clip.names), 1, 1)), clip.offsets[None])


def chain(parents: np.ndarray, rotations: np.ndarray, positions: np.ndarray) -> Placement:
    """Return joints in the world from rotations (k, J, 3, 3) and positions (k, J, 3) in their parents. Pure."""
    local = positions
    rotations = rotations.copy()
    positions = positions.copy()
    for joint in np.flatnonzero(parents >= 0):
        parent = parents[joint]
        positions[:, joint] = positions[:, parent] + np.einsum("kij,kj->ki", rotations[:, parent], positions[:, joint])
        rotations[:, joint] = rotations[:, parent] @ rotations[:, joint]
    return Placement(rotations, positions, local)


def local_turns(clip: Clip, frames: np.ndarray) -> Rotation:
    """Return the rotation of every joint in its parent at whole frames (k,), those of a frame together, k J. Pure.

    The first rotation channel of a joint is the outermost: R = R_first R_second R_third.
    """
    most = max(sum(name.endswith("rotation") for name in names) for names in clip.channels)
    turns = np.zeros((most, len(frames), len(clip.names), 3))  # as rotation vectors
    values = iter(clip.values[frames].T)
    for joint, names in enumerate(clip.channels):
        rotations = [pair for pair in zip(names, values, strict=False) if pair[0].endswith("rotation")]
        for turn, (name, degrees) in zip(turns, rotations, strict=False):
            turn[:, joint, AXES[name[0]]] = np.radians(degrees)
    still = Rotation.identity(len(frames) * len(clip.names))
    return math.prod((Rotation.from_rotvec(turn.reshape(-1, 3)) for turn in turns), start=still)


def local_positions(clip: Clip, frames: np.ndarray) -> np.ndarray:
    """Return the position of every joint in its parent at whole frames (k,), (k, J, 3). Pure."""
    positions = np.tile(clip.offsets, (len(frames), 1, 1))
    column = 0
    for joint, names in enumerate(clip.channels):
        moves = [(AXES[name[0]], column + i) for i, name in enumerate(names) if name.endswith("position")]
        if moves:
            axes, columns = map(list, zip(*moves, strict=True))
            positions[:, joint, axes] = clip.values[np.ix_(frames, columns)]
        column += len(names)
    return positions
