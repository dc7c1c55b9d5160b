"""Motion of the joints of a file: poses of the body of that file, or a clip for other bodies."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from hairpipe.formats.animated_meshes import Instant, Points, Shape, place, read_at
from hairpipe.formats.rigging import rigid
from hairpipe.values import BlendShapes, Mesh, Pose, Skeleton
from hairpipe.values.body import Clip

ALIKE = 1e-6
"""Largest difference of joints at rest [m]."""
NAMED = 12
"""Names of a list that a warning has."""
CHANNELS = ("Xposition", "Yposition", "Zposition", "Zrotation", "Yrotation", "Xrotation")


@dataclass(eq=False)
class JointMotion:
    """Samples of J joints and K weights; a `hairpipe.formats.animated_meshes.Source`.

    Its point 4 j + k is column k of joint j; points of a second piece are weights.

    skeleton  joints at rest
    world     joint-to-world matrices that move the skin at rest as the file does [m], (t, J, 4, 4)
    codes     time codes of the samples, ascending, (t,)
    rate      time codes per second [1/s]
    start     time code at which the clip begins
    shapes    names of the weights of blend shapes, K
    weights   at the samples, (t, K)
    """

    skeleton: Skeleton
    world: np.ndarray
    codes: np.ndarray
    rate: float
    start: float
    shapes: tuple[str, ...]
    weights: np.ndarray
    own: Sequence[bool] = (False, False)

    def shape(self, sample: int) -> Shape:
        """Return the columns and weights at a sample as points without triangles."""
        points = np.concatenate([points for points, _ in self.sample(sample)])
        return Shape(Mesh(points, np.zeros((0, 3), np.int32)), np.zeros(0, np.int64))

    def sample(self, sample: int) -> list[Points]:
        """Return the columns and the weights at a sample."""
        columns = self.world[sample, :, :3].swapaxes(1, 2).reshape(-1, 3)
        return [(columns, None), (np.repeat(self.weights[sample][:, None], 3, axis=1), None)]


def sample_pose(motion: JointMotion, instant: Instant) -> Pose:
    """Return joints and weights at an instant, in the order of the motion.

    instant  its start is a time of the clip [s], or None
    """
    start = None if instant.start is None else motion.start + instant.start * motion.rate
    found, _ = read_at(motion, replace(instant, start=start), lambda code: (code - motion.start) / motion.rate)
    joints = len(motion.skeleton.names)
    transforms, rates = (np.zeros((joints, 4, 4)) for _ in range(2))
    transforms[:, 3, 3] = 1.0
    for result, columns in ((transforms, found.points), (rates, found.rates)):
        result[:, :3] = columns[: 4 * joints].reshape(-1, 4, 3).swapaxes(1, 2)
    return Pose(transforms, rates, found.points[4 * joints :, 0], found.rates[4 * joints :, 0])


def start_of(motion: JointMotion, instant: Instant) -> float:
    """Return the time of the clip at the frame `at` of an instant, as of `sample_pose` [s]; pure."""
    return (
        (place(motion.codes, motion.rate, instant) - motion.start) / motion.rate
        if instant.start is None
        else instant.start
    )


def pose_of(motion: JointMotion, skeleton: Skeleton, sampled: Pose) -> Pose | None:
    """Return a sampled pose as that of a skeleton; None, with a warning, where joints at rest are not its own.

    Joints rest where a motion has weights of blend shapes alone. Pure.
    """
    own = motion.skeleton
    if not own.names:
        return Pose(skeleton.rest.copy(), np.zeros_like(skeleton.rest))
    order = [own.names.index(name) for name in skeleton.names if name in own.names]
    if len(order) < len(skeleton.names) or np.abs(own.rest[order] - skeleton.rest).max() > ALIKE:
        message = "the joints at rest are not those of the body, to which the motion is retargeted"
        warnings.warn(f"{message} (a setting of BVH clips, such as skip = 0, silences this warning)", stacklevel=2)
        return None
    return Pose(sampled.transforms[order], sampled.rates[order])


def weighted(pose: Pose, names: Sequence[str], sampled: Pose, shapes: BlendShapes | None) -> Pose:
    """Return a pose with sampled weights, by name, of the blend shapes of a body; others are those at rest. Pure.

    names  of the sampled weights

    Warns of names that the body or a motion with weights does not have.
    """
    own = () if shapes is None else shapes.names
    lost, still = ([n for n in a if n not in b] for a, b in ((names, own), (own, names)))
    if lost:
        rest = f"; {', '.join(still[:NAMED])} of the body stay at rest" if still else ""
        warnings.warn(f"weights without a blend shape of the body: {', '.join(lost[:NAMED])}{rest}", stacklevel=2)
    elif names and still:
        warnings.warn(f"blend shapes without a weight, which stay at rest: {', '.join(still[:NAMED])}", stacklevel=2)
    if shapes is None or sampled.weights is None or sampled.weight_rates is None:
        return pose
    weights = shapes.rest.copy()
    rates = np.zeros(len(own))
    for k, name in enumerate(own):
        if name in names:
            weights[k], rates[k] = sampled.weights[names.index(name)], sampled.weight_rates[names.index(name)]
    return replace(pose, weights=weights, weight_rates=rates)


@lru_cache(maxsize=8)
def clip_of(motion: JointMotion) -> Clip:
    """Return the motion as a clip with a frame at each time code; all channels are zero at rest. Scale is left out."""
    from scipy.spatial.transform import Rotation

    own = motion.skeleton
    codes = np.arange(motion.start, motion.codes[-1] + 1e-6)
    place = np.interp(codes, motion.codes, np.arange(len(motion.codes)))
    before = place.astype(np.int64)
    share = (place - before)[:, None, None, None]
    world = (1.0 - share) * motion.world[before] + share * motion.world[np.minimum(before + 1, len(motion.codes) - 1)]
    turns = rigid((world @ np.linalg.inv(own.rest)).reshape(-1, 4, 4)).reshape(world.shape)[..., :3, :3]
    offsets = own.rest[:, :3, 3].copy()
    origins = world[..., :3, 3].copy()
    for joint in np.flatnonzero(own.parents >= 0)[::-1]:
        above = own.parents[joint]
        offsets[joint] -= offsets[above]
        origins[:, joint] = np.einsum("fij,fi->fj", turns[:, above], origins[:, joint] - origins[:, above])
        turns[:, joint] = turns[:, above].swapaxes(1, 2) @ turns[:, joint]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # two of three angles are one where the second is a right angle
        angles = Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_euler("ZYX", degrees=True)
    values = np.concatenate([origins, angles.reshape(origins.shape)], axis=2).reshape(len(codes), -1)
    ends = np.full_like(offsets, np.nan)
    return Clip(own.names, own.parents, offsets, ends, (CHANNELS,) * len(ends), values, 1.0 / motion.rate)
