"""Bake a body as one level set for each group of bones, in the frame of the bones."""

from dataclasses import replace
from functools import lru_cache
from warnings import warn

import numpy as np

from hairpipe.body.groups import group_bones
from hairpipe.body.skinning import skin
from hairpipe.data import Body, BodyParts, LevelSet, Pose
from hairpipe.errors import BadInput
from hairpipe.levelset.bake.closed_surface import Surface
from hairpipe.levelset.bake.split_parts import Cut, closed, cut_skin
from hairpipe.levelset.bake.whole import bake_surface
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.spatial.triangle_tree import wide_triangles

# Along the skin beyond the middle between two bones, in voxels: the caps lie inside the neighbour, where none touches.
OVERLAP = 3.0
# Local vertices are rounded to this many steps in a metre: what is rigid in its frame has the same bytes at all frames.
STEPS = 2.0**20
REMEMBERED = 64
# Of the area of a part, without a word: caps, which lie inside neighbours, lose up to 3 % of MakeHuman's at 5 to 20 mm.
LOST = 0.05


def bake_parts(rest: Body, pose: Pose | None, voxel: float, half_width: float, smallest: float) -> BodyParts:
    """Return the parts of a body in a pose; without a pose, at rest and static. Pure.

    voxel       spacing of the samples [m]
    half_width  half width of the band, in voxels
    smallest    minimum size of a part of the skin [m]; bones with less move with their parents

    The skin of a part is the posed one: skin shared by neighbours is bent in the frames of both. Raises BadInput as
    `skin` and, naming the part, `bake` do, and warns of parts that are too thin for the voxel.
    """
    points = skin(rest, pose).points
    groups = group_bones(rest, smallest)
    cuts = cut_skin(rest, groups, OVERLAP * voxel)
    poses, rates = frames_of(rest, pose, groups.leaders[[cut.group for cut in cuts]])
    names = (*rest.skeleton.names, "body")  # the last is led by none, -1
    labels = tuple(names[groups.leaders[cut.group]] for cut in cuts)
    found, lost = [], []
    for label, cut, place in zip(labels, cuts, poses, strict=True):
        try:
            part, share = bake_part(cut, points, place, voxel, half_width)
        except BadInput as error:
            right = f"{error.right}; with a larger `smallest` small parts join their parents"
            raise BadInput(error.what, where=f"{error.where}, part {label}", right=right) from error
        found.append(part)
        lost += [label] * (share > LOST)
    if lost:
        thin = f"more than {LOST:.0%} of {', '.join(lost)}"
        warn(f"body: {thin} is too thin for voxel = {voxel:g} m, and does not stop hair", stacklevel=2)
    return gathered(labels, poses, rates, found)


def frames_of(rest: Body, pose: Pose | None, leaders: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the frames of bones, [R | p] [m] and its rate, (G, 3, 4) each, R being the rotation since rest; pure.

    leaders  the bones, (G,), whose joints are p; -1: no bone, with the frame of the world
    """
    poses = np.tile(np.eye(3, 4), (len(leaders), 1, 1))
    rates = np.zeros((len(leaders), 3, 4))
    has_leader = leaders >= 0
    bones = rest.skeleton.rest[leaders[has_leader]]
    poses[has_leader] = bones[:, :3]
    if pose is not None:
        poses[has_leader], rates[has_leader] = (
            pose.transforms[leaders[has_leader], :3],
            pose.rates[leaders[has_leader], :3],
        )
    unbind = np.swapaxes(bones[:, :3, :3], 1, 2)
    poses[has_leader, :, :3] = poses[has_leader, :, :3] @ unbind
    rates[has_leader, :, :3] = rates[has_leader, :, :3] @ unbind
    return poses, rates


def bake_part(
    cut: Cut, points: np.ndarray, place: np.ndarray, voxel: float, half_width: float
) -> tuple[LevelSet, float]:
    """Return the level set of a part in its own frame, and the share of its area that is too thin for the voxel.

    points  points of the posed skin [m], (n, 3) float64
    place   [R | p] of the part [m], (3, 4) float64
    """
    local = (points[cut.vertices] - place[:, 3]) @ place[:, :3]
    rounded = np.round(local * STEPS) / STEPS + 0.0
    return bake_once(rounded.tobytes(), cut.triangles.tobytes(), cut.rim.tobytes(), voxel, half_width)


@lru_cache(maxsize=REMEMBERED)
def bake_once(points: bytes, triangles: bytes, rim: bytes, voxel: float, half_width: float) -> tuple[LevelSet, float]:
    """Return the level set of an open patch, closed by caps, without velocities; see `closed`, `bake_surface`."""
    patch = np.frombuffer(points).reshape(-1, 3), np.frombuffer(triangles, np.int32).reshape(-1, 3)
    mesh = closed(*patch, np.frombuffer(rim, bool))
    surface = Surface(mesh.points[mesh.triangles], np.zeros((len(mesh.triangles), 3, 3)))
    wide_triangles(surface.corners)
    found, lost = bake_surface(surface, lattice_around(surface.corners, voxel, half_width), half_width)
    return replace(found, velocity=np.empty((0, *found.velocity.shape[1:]), np.float32)), lost


def gathered(names: tuple[str, ...], poses: np.ndarray, rates: np.ndarray, parts: list[LevelSet]) -> BodyParts:
    """Return level sets as the parts of a body; pure."""
    starts = np.cumsum([0] + [part.bricks.size for part in parts])
    firsts = np.cumsum([0] + [len(part.distance) for part in parts])
    bricks = [
        np.where(part.bricks >= 0, part.bricks + first, part.bricks).ravel()
        for part, first in zip(parts, firsts, strict=False)
    ]
    return BodyParts(
        names,
        poses,
        rates,
        starts.astype(np.int64),
        np.array([part.bricks.shape for part in parts], np.int32),
        np.array([part.origin for part in parts]),
        np.concatenate(bricks).astype(np.int32),
        np.concatenate([part.distance for part in parts]),
        np.concatenate([part.inner[..., 0].ravel() for part in parts]),
        parts[0].voxel,
        parts[0].half_width,
    )
