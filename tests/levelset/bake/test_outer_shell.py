"""Only what the outside touches of a surface is kept, and what is too thin for the samples is told."""

import numpy as np
import pytest

from hairpipe.levelset.closed_surface import Surface
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.levelset.outer_shell import marked_samples, outer_surface
from hairpipe.values import Mesh


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


def test_a_part_within_another_is_dropped(sphere, together):
    mesh = sphere(level=3)
    outer = outer_of(together(mesh, sphere(0.5, level=2)), 0.1)
    assert np.array_equal(outer.surface.corners, mesh.points[mesh.triangles])


def test_sheets_hidden_in_an_overlap_are_dropped(sphere, together):
    voxel, centre = 0.06, np.array([1.0, 0.0, 0.0])
    outer = outer_of(together(sphere(level=4), sphere(centre=centre, level=4)), voxel)
    middles = outer.surface.corners.mean(axis=1)
    depth = 1 - np.minimum(np.linalg.norm(middles, axis=1), np.linalg.norm(middles - centre, axis=1))
    assert depth.max() < 2.5 * voxel
    # Two unit spheres a radius apart each show 3/4 of their area, and flaps of two voxels along the circle they share.
    shown = 2 * 0.75 * area(sphere(level=4).points[sphere(level=4).triangles])
    assert shown < area(outer.surface.corners) < shown + 2 * 2 * voxel * 2 * np.pi * np.sqrt(0.75)


def test_pieces_move_as_the_triangles_they_are_cut_from(sphere, together):
    outer = outer_of(together(sphere(level=2), sphere(centre=(1.0, 0, 0), level=2)), 0.1)
    assert len(outer.surface.corners) > 256
    assert np.allclose(outer.surface.velocities, np.cross([0, 0, 1.0], outer.surface.corners), atol=1e-12)


def test_a_sheet_thinner_than_the_samples_is_lost(box, together):
    sheet = box((1.0, -0.5, 0.01), (2.0, 0.5, 0.02))
    outer = outer_of(together(box(), sheet), 0.1)
    assert outer.lost == pytest.approx(2.04 / 8.04, abs=0.02)
    assert area(outer.surface.corners) == pytest.approx(8.04)
