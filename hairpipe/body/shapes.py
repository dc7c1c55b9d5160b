"""Bodies of known shape: cylinders, capsules, balls and boxes, closed and outward."""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.rotations import frame_along
from hairpipe.values import Mesh

Vector = tuple[float, float, float]


def build_cylinder(radius: float, length: float, is_round: bool, around: int, centre: Vector, along: Vector) -> Mesh:
    """Return a cylinder about an axis, whose ends are flat or half balls; vertices lie on the true surface.

    length  between the ends, without half balls [m]; 0 with half balls is a ball
    around  number of facets; a half ball has a quarter as many from its rim to its pole

    Raises BadInput where the axis has no direction, or a flat cylinder no length.
    """
    if not np.linalg.norm(along) > 0.0:
        raise BadInput(f"direction = {list(along)} has no length", right="any other vector")
    if not is_round and length == 0.0:
        raise BadInput("a cylinder with flat ends and no length", right='length > 0, or ends = "round"')
    angles = np.linspace(0.0, 0.5 * np.pi, max(around // 4, 2) + 1)[1:] if is_round else np.array([0.5 * np.pi])
    half = radius * np.column_stack([np.sin(angles), np.cos(angles)])
    end = np.array([0.0, 0.5 * length])
    upper = half + end
    lower = (half * [1.0, -1.0] - end)[: None if length else -1]
    top = 0.5 * length + is_round * radius
    bottom = -0.5 * length - is_round * radius
    profile = np.concatenate([lower, upper[::-1]])  # radii and heights, from below, turned about the third axis
    angles = 2.0 * np.pi * np.arange(around) / around
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = np.concatenate([profile[:, None, :1] * circle, np.tile(profile[:, None, 1:], (1, around, 1))], axis=2)
    points = np.concatenate([rings.reshape(-1, 3), [[0.0, 0.0, bottom], [0.0, 0.0, top]]])
    here = np.arange(around)
    there = np.roll(here, -1)
    last = (len(profile) - 1) * around
    triangles = [np.column_stack([there, here, np.full(around, len(points) - 2)])]
    for ring in range(len(profile) - 1):
        a, b = ring * around + here, ring * around + there
        triangles += [np.column_stack([a, b, b + around]), np.column_stack([a, b + around, a + around])]
    triangles.append(np.column_stack([last + here, last + there, np.full(around, len(points) - 1)]))
    frame = frame_along(np.array(along) / np.linalg.norm(along))
    return Mesh(points @ frame.T + centre, np.concatenate(triangles).astype(np.int32))


def build_box(size: Vector, centre: Vector) -> Mesh:
    """Return a box along the axes; size and centre [m]."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    sides = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    triangles = np.concatenate([sides[:, [0, 1, 2]], sides[:, [0, 2, 3]]]).astype(np.int32)
    return Mesh(corners * size + centre, triangles)


def join(meshes: tuple[Mesh, ...]) -> Mesh:
    """Return several meshes as one, each in its own place.

    Those without velocities are static; those without texture coordinates have 0 where others have some.
    """
    firsts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])
    still, bare = all(mesh.velocities is None for mesh in meshes), all(mesh.uv is None for mesh in meshes)
    coordinates = [np.zeros((len(m.triangles), 3, 2), np.float32) if m.uv is None else m.uv for m in meshes]
    return Mesh(
        np.concatenate([mesh.points for mesh in meshes]),
        np.concatenate([mesh.triangles + first for mesh, first in zip(meshes, firsts, strict=False)]).astype(np.int32),
        None if still else np.concatenate([mesh.rates for mesh in meshes]),
        None if bare else np.concatenate(coordinates),
    )
