"""Samples that can be reached from outside, and what of a surface they touch."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hairpipe.levelset.closed_surface import Surface
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.levelset.outer_shell import OUTSIDE, marked_samples, outer_surface
from hairpipe.values import Mesh

from ..conftest import together, torus


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


def test_parts_that_overlap_are_one(sphere):
    parts = sphere(level=3), sphere(centre=(0.9, 0.2, 0.0), level=3)
    points, outside = samples_of(together(*parts), 0.11)
    assert (outside == (is_outside_convex(parts[0], points) & is_outside_convex(parts[1], points))).all()


def test_enclosed_samples_are_inside(sphere):
    hollow = together(sphere(level=3), sphere(0.6, level=3))
    points, outside = samples_of(hollow, 0.11)
    assert (outside == is_outside_convex(sphere(level=3), points)).all()


def test_a_cavity_with_a_way_out_is_outside(box):
    # A cup: a floor and four walls, open above.
    walls = [((-1, 0, -1), (1, 0.2, 1)), ((-1, 0, -1), (-0.8, 1, 1)), ((0.8, 0, -1), (1, 1, 1))]
    walls += [((-1, 0, -1), (1, 1, -0.8)), ((-1, 0, 0.8), (1, 1, 1))]
    points, outside = samples_of(together(*[box(*wall) for wall in walls]), 0.09)
    within = (np.abs(points[..., [0, 2]]) < 0.79).all(axis=-1) & (points[..., 1] > 0.21)
    assert within.any()
    assert outside[within].all()


def test_sign_of_a_body_agrees_with_the_winding_number():
    mesh = torus(1.0, 0.4, 24)
    points, outside = samples_of(mesh, 0.2)
    chosen = np.random.default_rng(0).integers(0, outside.size, 2000)
    a, b, c = (mesh.points[mesh.triangles[:, k]][None] - points.reshape(-1, 3)[chosen][:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    ab, bc, ca = (np.einsum("ptj,ptj->pt", x, y) for x, y in ((a, b), (b, c), (c, a)))
    solid = 2 * np.arctan2(np.einsum("ptj,ptj->pt", a, np.cross(b, c)), la * lb * lc + ab * lc + bc * la + ca * lb)
    winding = solid.sum(axis=1) / (4 * np.pi)
    assert (outside.ravel()[chosen] == (np.abs(winding) < 0.5)).all()


def outer_of(mesh: Mesh, voxel: float):
    corners = mesh.points[mesh.triangles]
    surface = Surface(corners, np.cross([0, 0, 1.0], corners))
    lattice = lattice_around(corners, voxel, 2.0)
    return outer_surface(surface, marked_samples(corners, lattice), lattice)


def area(corners: np.ndarray) -> float:
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(sides, axis=1).sum() / 2


def test_a_simple_surface_is_kept_as_it_is(sphere):
    mesh = sphere(level=3)
    outer = outer_of(mesh, 0.1)
    assert np.array_equal(outer.surface.corners, mesh.points[mesh.triangles])
    assert outer.lost == 0


def test_faces_that_lie_on_samples_are_kept(box):
    assert area(outer_of(box(), 0.125).surface.corners) == pytest.approx(6)


def test_a_part_within_another_is_dropped(sphere):
    mesh = sphere(level=3)
    outer = outer_of(together(mesh, sphere(0.5, level=2)), 0.1)
    assert np.array_equal(outer.surface.corners, mesh.points[mesh.triangles])


def test_sheets_hidden_in_an_overlap_are_dropped(sphere):
    voxel, centre = 0.06, np.array([1.0, 0.0, 0.0])
    outer = outer_of(together(sphere(level=4), sphere(centre=centre, level=4)), voxel)
    middles = outer.surface.corners.mean(axis=1)
    depth = 1 - np.minimum(np.linalg.norm(middles, axis=1), np.linalg.norm(middles - centre, axis=1))
    assert depth.max() < 2.5 * voxel
    # Two unit spheres a radius apart each show 3/4 of their area, and flaps of two voxels along the circle they share.
    shown = 2 * 0.75 * area(sphere(level=4).points[sphere(level=4).triangles])
    assert shown < area(outer.surface.corners) < shown + 2 * 2 * voxel * 2 * np.pi * np.sqrt(0.75)


def test_pieces_move_as_the_triangles_they_are_cut_from(sphere):
    outer = outer_of(together(sphere(level=2), sphere(centre=(1.0, 0, 0), level=2)), 0.1)
    assert len(outer.surface.corners) > 256
    assert np.allclose(outer.surface.velocities, np.cross([0, 0, 1.0], outer.surface.corners), atol=1e-12)


def test_a_sheet_thinner_than_the_samples_is_lost(box):
    sheet = box((1.0, -0.5, 0.01), (2.0, 0.5, 0.02))
    outer = outer_of(together(box(), sheet), 0.1)
    assert outer.lost == pytest.approx(2.04 / 8.04, abs=0.02)
    assert area(outer.surface.corners) == pytest.approx(8.04)
