"""The samples that can be reached from outside are those outside, whatever the mesh is like."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.levelset.outer_shell import OUTSIDE, marked_samples


def samples_of(mesh, voxel):
    """Positions of the samples, and which of them are outside."""
    corners = mesh.points[mesh.triangles]
    lattice = lattice_around(corners, voxel, 2.0)
    marks = marked_samples(corners, lattice)
    index = np.stack(np.meshgrid(*map(np.arange, lattice.samples), indexing="ij"), axis=-1)
    return (lattice.first + index) * voxel, marks & OUTSIDE > 0


def heights_over(mesh, points):
    """Heights over the planes of the triangles, times twice their areas."""
    a, b, c = mesh.points[mesh.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    return np.einsum("...j,tj->...t", points, normals) - np.einsum("tj,tj->t", normals, a)


def is_outside_convex(mesh, points):
    return (heights_over(mesh, points) > 1e-12).any(axis=-1)


@pytest.mark.parametrize("voxel", [0.11, 0.25])
def test_sphere(sphere, voxel):
    points, outside = samples_of(sphere(level=3), voxel)
    assert (outside == is_outside_convex(sphere(level=3), points)).all()


@settings(deadline=None, max_examples=25)
@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-1, 1)] * 3))
def test_boxes_any_way_round(box, turn, shift):
    mesh = box()
    mesh.points[:] = Rotation.from_rotvec(turn).apply(mesh.points) + shift
    points, outside = samples_of(mesh, 0.13)
    clear = (np.abs(heights_over(mesh, points)) > 1e-9).all(axis=-1)  # on a face, rounding decides
    assert (outside == is_outside_convex(mesh, points))[clear].all()


def test_nothing_leaks_between_triangles_that_meet_on_samples(box):
    # Faces, diagonals, edges and corners all lie on samples; those on the surface count as inside.
    points, outside = samples_of(box(), 0.125)
    assert (outside == (np.abs(points) > 0.5).any(axis=-1)).all()


def test_orientation_does_not_matter(sphere):
    mesh = sphere(level=2)
    _, outside = samples_of(mesh, 0.15)
    mesh.triangles[::3] = mesh.triangles[::3, ::-1]
    assert (samples_of(mesh, 0.15)[1] == outside).all()


def test_parts_that_overlap_are_one(sphere, together):
    parts = sphere(level=3), sphere(centre=(0.9, 0.2, 0.0), level=3)
    points, outside = samples_of(together(*parts), 0.11)
    assert (outside == (is_outside_convex(parts[0], points) & is_outside_convex(parts[1], points))).all()


def test_enclosed_samples_are_inside(sphere, together):
    hollow = together(sphere(level=3), sphere(0.6, level=3))
    points, outside = samples_of(hollow, 0.11)
    assert (outside == is_outside_convex(sphere(level=3), points)).all()


def test_a_cavity_with_a_way_out_is_outside(box, together):
    # A cup: a floor and four walls, open above.
    walls = [((-1, 0, -1), (1, 0.2, 1)), ((-1, 0, -1), (-0.8, 1, 1)), ((0.8, 0, -1), (1, 1, 1))]
    walls += [((-1, 0, -1), (1, 1, -0.8)), ((-1, 0, 0.8), (1, 1, 1))]
    points, outside = samples_of(together(*[box(*wall) for wall in walls]), 0.09)
    within = (np.abs(points[..., [0, 2]]) < 0.79).all(axis=-1) & (points[..., 1] > 0.21)
    assert within.any()
    assert outside[within].all()


def test_sign_of_a_body_agrees_with_the_winding_number(torus):
    mesh = torus(1.0, 0.4, 24)
    points, outside = samples_of(mesh, 0.2)
    chosen = np.random.default_rng(0).integers(0, outside.size, 2000)
    a, b, c = (mesh.points[mesh.triangles[:, k]][None] - points.reshape(-1, 3)[chosen][:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    ab, bc, ca = (np.einsum("ptj,ptj->pt", x, y) for x, y in ((a, b), (b, c), (c, a)))
    solid = 2 * np.arctan2(np.einsum("ptj,ptj->pt", a, np.cross(b, c)), la * lb * lc + ab * lc + bc * la + ca * lb)
    winding = solid.sum(axis=1) / (4 * np.pi)
    assert (outside.ravel()[chosen] == (np.abs(winding) < 0.5)).all()
