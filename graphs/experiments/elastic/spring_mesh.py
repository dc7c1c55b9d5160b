"""The springs of a solid and of a shell, Sec. 3.1 of Selle, Lentine, Fedkiw 2008, with constants from their matter.

A network of linear springs between random neighbours is an isotropic material. With C the sum of k l over its springs,
k the force per unit strain, per volume: C_1111 = C / 5 and Poisson's ratio 1/4, so C = 6 E; six edges of a tetrahedron
of volume V give k = E V / l each. Per area of a sheet: C_1111 = 3 C / 8, Poisson's ratio 1/3, so C = 3 E t; three edges
of a triangle of area A give k = E t A / l. A hinge of length l between two triangles of areas A and B bends with
D l^2 / (A + B) theta^2 / 2, D = E t^3 / (12 (1 - 1/9)): exact for a sheet of equilateral triangles, after
Seung and Nelson 1988.

Which altitude acts changes, and with it the rest height h0 that a strain is measured by; k is a force per unit strain
of the shortest altitude of a solid. A shell has altitudes of rest height 0 where it is flat, so for it the stiffness
k / max(|h0|, least) has a `least` that is larger than any h0: the hinge is a spring of constant stiffness.
"""

from typing import NamedTuple

import numpy as np

from hairpipe.geometry.simd import WIDTH
from hairpipe.graphs.experiments.elastic import mesh_geometry
from hairpipe.graphs.experiments.elastic.elastic_values import Shell, Solid
from hairpipe.graphs.experiments.elastic.hinges import PAIRS, hinges, tetrahedron_edges, triangle_edges
from hairpipe.graphs.experiments.elastic.matter import Altitudes, Fabric, Rubber
from hairpipe.graphs.experiments.elastic.sparsity import Pattern, find_pattern

POISSON = 1 / 3


class Springs(NamedTuple):
    """Everything about a body of springs that does not change.

    mass      of the particles [kg], (n,)
    free      1 where a particle may move, else 0, (n, 3)
    pairs     ends of the linear springs, (e, 2) int32
    pulls     their force per unit strain [N], (e,)
    inverse   1 / l0 [1/m], (e,)
    fours     particles of the altitude springs, the last four repeated to fill the lanes, (t, 4) int32
    presses   their force per unit strain [N], 0 where repeated, (blocks, W)
    heights   signed rest heights of the seven candidates [m], (blocks, 7, W)
    least     rest heights count as at least this in the stiffness [m], (blocks, W)
    altitudes  0 none, 1 the selected one, 4 those of all faces
    pattern   of the matrix
    """

    mass: np.ndarray
    free: np.ndarray
    pairs: np.ndarray
    pulls: np.ndarray
    inverse: np.ndarray
    fours: np.ndarray
    presses: np.ndarray
    heights: np.ndarray
    least: np.ndarray
    altitudes: int
    pattern: Pattern


def solid_springs(solid: Solid, rubber: Rubber) -> Springs:
    """Make the springs of a solid that is at rest as it is."""
    points, fours = solid.points, solid.tetrahedra
    volume = mesh_geometry.volumes(points, fours)
    edges, which = tetrahedron_edges(fours)
    length = mesh_geometry.lengths(points, edges)
    shares = np.bincount(which.ravel(), np.repeat(volume, len(PAIRS)), len(edges))
    mass = np.bincount(fours.ravel(), np.repeat(rubber.density * volume / 4, 4), len(points))
    heights = mesh_geometry.altitudes(points, fours)
    shortest = np.abs(heights).min(axis=1)
    presses = rubber.young * volume / shortest
    moves = np.ones(len(points), bool)
    pulls = rubber.young * shares / length
    return _springs(mass, moves, (edges, pulls, length), (fours, presses, heights, 0 * shortest), rubber.altitudes)


def shell_springs(shell: Shell, fabric: Fabric) -> Springs:
    """Make the springs of a shell that is at rest as it is: edges, across every inner edge, and altitudes there."""
    points, triangles = shell.points, shell.triangles
    area = mesh_geometry.areas(points, triangles)
    edges, which = triangle_edges(triangles)
    length = mesh_geometry.lengths(points, edges)
    pulls = fabric.young * fabric.thickness * np.bincount(which.ravel(), np.repeat(area, 3), len(edges)) / length
    mass = np.bincount(triangles.ravel(), np.repeat(fabric.density * fabric.thickness * area / 3, 3), len(points))
    fours = hinges(triangles)
    a, b, c, d = fours.T
    first, second = (mesh_geometry.areas(points, np.stack([a, b, tip], 1)) for tip in (c, d))
    axis = mesh_geometry.lengths(points, fours[:, :2])
    span = mesh_geometry.lengths(points, fours[:, 2:])
    crossing = fabric.across * fabric.young * fabric.thickness * (first + second) / 2 / span
    rigidity = fabric.young * fabric.thickness**3 / (12 * (1 - POISSON**2))
    # theta = h (1/H + 1/H'), H = 2 A / l the heights of the two triangles.
    stiffness = rigidity * axis**2 / (first + second) * (axis / 2 * (1 / first + 1 / second)) ** 2
    heights = mesh_geometry.altitudes(points, fours)
    least = np.maximum(np.abs(heights).max(axis=1), 1e-3 * span)
    linear = np.concatenate([edges, fours[:, 2:]]), np.concatenate([pulls, crossing]), np.concatenate([length, span])
    return _springs(mass, ~shell.pinned, linear, (fours, stiffness * least, heights, least), fabric.altitudes)


def _springs(mass: np.ndarray, moves: np.ndarray, linear: tuple, fours: tuple, altitudes: Altitudes) -> Springs:
    """Lay altitude springs in lanes.

    moves   which particles do, (n,)
    linear  pairs, force per unit strain, rest length; fours  particles, force per unit strain, rest heights, least
    """
    pairs, pulls, length = linear
    fours, presses, heights, least = fours
    missing = -len(fours) % WIDTH
    full = np.concatenate([fours, np.repeat(fours[-1:], missing, axis=0)]).astype(np.int32)
    presses = np.concatenate([presses, np.zeros(missing)]).reshape(-1, WIDTH)
    heights = np.concatenate([heights, np.repeat(heights[-1:], missing, axis=0)])
    heights = np.ascontiguousarray(heights.reshape(-1, WIDTH, 7).transpose(0, 2, 1))
    least = np.concatenate([least, np.repeat(least[-1:], missing)]).reshape(-1, WIDTH)
    free = np.repeat(moves[:, None].astype(float), 3, axis=1)
    number = {"none": 0, "selected": 1, "faces": 4}[altitudes]
    pairs, pattern = pairs.astype(np.int32), find_pattern(len(mass), pairs, full)
    return Springs(mass, free, pairs, pulls, 1 / length, full, presses, heights, least, number, pattern)
