"""The rig of a file of any format: joints and blend shapes of a body at rest, and their motion.

Readers of glTF and of UsdSkel give the meshes of a body as `Part`s, and poses as a `JointMotion`.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant, Points, place, read_at
from hairpipe.formats.polygons import Polygons, merge_meshes
from hairpipe.values import BlendShapes, Body, Bound, DualQuaternions, Mesh, Pose, Skeleton
from hairpipe.values.body import Clip

ROUNDED = 1e-9
"""Largest difference of bound mesh and rest that rounding explains."""


NOBODY = Skeleton((), np.zeros(0, np.int32), np.zeros((0, 4, 4)), np.zeros((0, 3)))


class Key(NamedTuple):
    """One key of a blend shape of a mesh.

    name      of the weight
    place     value of the weight at which the key is reached
    vertices  of the mesh, (r,)
    offsets   displacement of the bound mesh [m], (r, 3) float64
    """

    name: str
    place: float
    vertices: np.ndarray
    offsets: np.ndarray


def unique_names(names: Sequence[str], owners: Sequence[object]) -> list[str]:
    """Return names, those that several owners have with the owner: smile#face. Pure."""
    owned = dict[str, set[object]]()
    for name, owner in zip(names, owners, strict=True):
        owned.setdefault(name, set()).add(owner)
    return [n if len(owned[n]) == 1 else f"{n}#{owner}" for n, owner in zip(names, owners, strict=True)]


def rigid(world: np.ndarray) -> np.ndarray:
    """Return the nearest rotations, and the origins, of affine matrices (J, 4, 4); our joints have no scale. Pure."""
    left, _, right = np.linalg.svd(world[:, :3, :3])
    left[:, :, 2] *= np.linalg.det(left @ right)[:, None]
    result = world.copy()
    result[:, :3, :3] = left @ right
    return result


def jointed(names: Sequence[str], parents: np.ndarray, rest: np.ndarray) -> Skeleton:
    """Return joints with the ends of their bones: the mean of the children; a leaf continues the bone of its parent."""
    origins = rest[:, :3, 3]
    tips = origins.copy()
    for joint, parent in enumerate(parents):
        children = np.flatnonzero(parents == joint)
        if len(children):
            tips[joint] = origins[children].mean(axis=0)
        elif parent >= 0:
            tips[joint] = 2 * origins[joint] - origins[parent]
    return Skeleton(tuple(names), parents, rest, tips)


class Part(NamedTuple):
    """One mesh of a body, of n vertices.

    mesh     at rest
    maps     painted values by name, (n,) float64 each in 0..1
    joints   joints of the whole skeleton that move each vertex, (n, k) int32, and their weights, rows of sum 1
    bound    points before blend shapes and joints act [m], (n, 3) float64
    keys     of its blend shapes
    """

    mesh: Mesh
    maps: dict[str, np.ndarray]
    joints: np.ndarray
    weights: np.ndarray
    bound: np.ndarray
    keys: list[Key]


def join_parts(
    parts: Sequence[Part],
    skeleton: Skeleton,
    turns: np.ndarray,
    rest: Mapping[str, float],
    time: float | None = None,
    dual: DualQuaternions | None = None,
) -> Body:
    """Join the meshes of a body; maps are 0 on meshes without them, and keys of one name follow one weight. Pure.

    turns  motion of every joint from the bound mesh to rest [m], column vectors, (J, 4, 4)
    rest   weights of blend shapes that are not 0 at rest

    Raises BadInput where a mesh has a key at a weight of 0, or two of a name at one weight.
    """
    counts = [len(part.bound) for part in parts]
    width = max(part.joints.shape[1] for part in parts)
    pads = [((0, 0), (0, width - part.joints.shape[1])) for part in parts]
    joints = np.concatenate([np.pad(part.joints, pad) for part, pad in zip(parts, pads, strict=True)])
    weights = np.concatenate([np.pad(part.weights, pad) for part, pad in zip(parts, pads, strict=True)])
    names = sorted({name for part in parts for name in part.maps})
    maps = {n: np.concatenate([p.maps.get(n, np.zeros(c)) for p, c in zip(parts, counts, strict=True)]) for n in names}
    is_turned = np.abs(turns - np.eye(4)).max(initial=0.0) >= ROUNDED
    bound = Bound(np.concatenate([part.bound for part in parts]), turns) if is_turned or any(rest.values()) else None
    shapes = _join_shapes([part.keys for part in parts], counts, rest)
    mesh = merge_meshes([part.mesh for part in parts])
    return Body(mesh, skeleton, joints, weights, maps, time, dual, shapes, bound)


def body_of(mesh: Mesh) -> Body:
    """Return a mesh as a body without joints."""
    return Body(mesh, NOBODY, np.zeros((len(mesh.points), 0), np.int32), np.zeros((len(mesh.points), 0)))


def _join_shapes(
    pieces: Sequence[Sequence[Key]], counts: Sequence[int], rest: Mapping[str, float]
) -> BlendShapes | None:
    firsts = np.cumsum([0, *counts])
    keys = [key._replace(vertices=key.vertices + first) for p, first in zip(pieces, firsts, strict=False) for key in p]
    if not keys:
        return None
    meshes = np.repeat(np.arange(len(pieces), dtype=np.int32), [len(piece) for piece in pieces])
    seen = set[tuple[int, str, float]]()
    for mesh, key in zip(meshes.tolist(), keys, strict=True):
        if not key.place or (mesh, key.name, key.place) in seen:
            what = f"{'a' if not key.place else 'a second'} key at the weight {key.place or 0.0:g}"
            where = f"blend shape {key.name} of mesh {mesh}"
            raise BadInput(what, where=where, right="one key at each weight, none at 0")
        seen.add((mesh, key.name, key.place))
    names = tuple(dict.fromkeys(key.name for key in keys))
    return BlendShapes(
        names,
        np.array([rest.get(name, 0.0) for name in names]),
        np.array([names.index(key.name) for key in keys], np.int32),
        meshes,
        np.array([key.place for key in keys], float),
        np.cumsum([0] + [len(key.vertices) for key in keys]),
        np.concatenate([key.vertices for key in keys]).astype(np.int32),
        np.concatenate([key.offsets for key in keys]),
    )


ALIKE = 1e-6
"""Largest difference of joints at rest [m]."""
NAMED = 12
"""Names of a list that a warning has."""
CHANNELS = ("Xposition", "Yposition", "Zposition", "Zrotation", "Yrotation", "Xrotation")


@dataclass(eq=False)
class JointMotion:
    """Samples of J joints and K weights of blend shapes, read as those of an animated mesh.

    Its point 4 j + k is column k of joint j; points of a second mesh are weights.

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

    def shape(self, sample: int) -> Polygons:
        points = np.concatenate([points for points, _ in self.sample(sample)])
        return Polygons(Mesh(points, np.zeros((0, 3), np.int32)), np.zeros(0, np.int64))

    def sample(self, sample: int) -> list[Points]:
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
    if instant.start is not None:
        return instant.start
    return (place(motion.codes, motion.rate, instant) - motion.start) / motion.rate


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
