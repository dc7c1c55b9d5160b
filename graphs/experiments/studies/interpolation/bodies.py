"""The level sets of bodies in motion, as every interpolation takes them."""
# pyright: reportCallIssue=false

import numpy as np

from hairpipe.geometry.collider import Collider
from hairpipe.graphs.experiments.studies.interpolation.cases import Case
from hairpipe.levelset.bake import bake
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.collider_parts import build_collider_parts
from hairpipe.levelset.sample import Interpolation
from hairpipe.values import BodyParts, LevelSet, Mesh
from hairpipe.values.body import gathered

FRAME = 1.0 / 24.0
"""Time between the frames [s]."""
INSTANT = 1e-4
"""Over which rates are taken [frames]."""


def poses_at(case: Case, a: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the poses of the solids a frames after the first, and their rates, (G, 3, 4) each."""
    return case.path(a), (case.path(a + INSTANT) - case.path(a - INSTANT)) / (2.0 * INSTANT * FRAME)


def skin_at(case: Case, a: float) -> Mesh:
    """Return the surfaces of all solids in the world, with velocities."""
    points = []
    triangles = []
    velocities = []
    count = 0
    for solid, pose, rate in zip(case.solids, *poses_at(case, a), strict=True):
        mesh = solid.mesh()
        points.append(mesh.points @ pose[:, :3].T + pose[:, 3])
        velocities.append(mesh.points @ rate[:, :3].T + rate[:, 3])
        triangles.append(mesh.triangles + count)
        count += len(mesh.points)
    return Mesh(np.concatenate(points), np.concatenate(triangles).astype(np.int32), np.concatenate(velocities))


def outline_at(case: Case, a: float) -> np.ndarray:
    """Return points on the surface of the union of the solids in the world [m], (n, 3)."""
    poses = case.path(a)
    found = []
    for one, (solid, pose) in enumerate(zip(case.solids, poses, strict=True)):
        points = solid.mesh().points @ pose[:, :3].T + pose[:, 3]
        others = [other for other in range(len(poses)) if other != one]
        hidden = [case.solids[n].contains((points - poses[n][:, 3]) @ poses[n][:, :3]) for n in others]
        found.append(points[~np.any(hidden, axis=0)] if hidden else points)
    return np.concatenate(found)


def parts_of(case: Case, shapes: list[LevelSet], a: float) -> BodyParts:
    """Return the solids as parts of a body; their shapes are baked in their own frames."""
    names = tuple(f"solid {n}" for n in range(len(shapes)))
    return gathered(names, *poses_at(case, a), shapes)


def surfaces_of(case: Case, voxel: float, half_width: float) -> dict[str, Collider]:
    """Return the body between the frames 0 and 1 by every interpolation, by name.

    voxel       spacing of the samples [m]
    half_width  of the band, in voxels
    """
    whole = [bake(skin_at(case, a), voxel, half_width) for a in (0.0, 1.0)]
    shapes = [bake(solid.mesh(), voxel, half_width) for solid in case.solids]
    found: dict[str, Collider] = {
        name: build_collider_field(*whole, FRAME, Interpolation[name]) for name in ("linear", "one_sided", "two_sided")
    }
    return found | {"parts": build_collider_parts(parts_of(case, shapes, 0.0), parts_of(case, shapes, 1.0), FRAME)}
