"""Samples that can be reached from outside, what of a surface they touch, and triangles that face outward."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hairpipe.body.preparation import drop_unused
from hairpipe.body.shapes import build_box, build_cylinder, join
from hairpipe.formats.registry import read_body
from hairpipe.groom.growing import closed
from hairpipe.levelset.closed_surface import Surface
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.levelset.outer_shell import OUTSIDE, facing_inward, marked_samples, outer_surface, turn, turned_outward
from hairpipe.nodes.grow_groom import grow_groom
from hairpipe.nodes.load_body import load_body
from hairpipe.nodes.make_bust import make_bust
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


BALL = build_cylinder(0.1, 0.0, True, 24, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
ROD = build_cylinder(0.02, 0.3, False, 12, (0.3, 0.0, 0.0), (0.0, 1.0, 0.2))
BOX = build_box((0.2, 0.3, 0.1), (0.0, 0.5, 0.0))
PARTS = join((BALL, ROD, BOX))


def reversed_where(mesh: Mesh, chosen: np.ndarray) -> Mesh:
    return turn(mesh, np.broadcast_to(chosen, len(mesh.triangles)))


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32), share=st.floats(0.0, 1.0), size=st.floats(1e-3, 1e3))
def test_reversed_triangles_are_found(seed, share, size):
    rng = np.random.default_rng(seed)
    chosen = rng.random(len(PARTS.triangles)) < share
    rotation = Rotation.random(rng=rng).as_matrix()
    mesh = Mesh(size * (PARTS.points @ rotation.T + rng.normal(size=3)), PARTS.triangles)
    np.testing.assert_array_equal(facing_inward(reversed_where(mesh, chosen)), chosen)


def test_a_reversed_part_is_found():
    owners = np.repeat([0, 1, 2], [len(part.triangles) for part in (BALL, ROD, BOX)])
    for part in range(3):
        np.testing.assert_array_equal(facing_inward(reversed_where(PARTS, owners == part)), owners == part)


def test_seams_and_gaps_do_not_matter():
    """One half mirrored, its points its own: at the seam of a texture, or two millimetres away."""
    mesh = make_bust().mesh
    right = mesh.points[mesh.triangles].mean(axis=1)[:, 0] > 0.0
    corners = np.arange(mesh.triangles.size, dtype=np.int32).reshape(-1, 3)
    soup = Mesh(mesh.points[mesh.triangles].reshape(-1, 3), corners)
    apart = soup.points.copy()
    apart[corners[right].ravel(), 0] += 0.002
    for points in (soup.points, apart):
        np.testing.assert_array_equal(facing_inward(reversed_where(Mesh(points, corners), right)), right)


def test_an_open_body_is_judged_by_what_it_encloses():
    opened = Mesh(BALL.points, BALL.triangles[BALL.points[BALL.triangles].mean(axis=1)[:, 1] < 0.06])
    assert len(closed(opened).triangles) > len(opened.triangles)
    for chosen in (False, True):
        assert (facing_inward(reversed_where(opened, np.array(chosen))) == chosen).all()


def test_cavities_sheets_and_rings_are_left_alone():
    """A cavity, whose wall faces into it; a sheet; a ring with one side."""
    hollow = join((BOX, reversed_where(build_box((0.1, 0.2, 0.05), (0.0, 0.5, 0.0)), np.array(True))))
    assert not facing_inward(hollow).any()
    assert facing_inward(reversed_where(hollow, np.array(True))).all()  # inside out as a whole
    sheet = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    for chosen in (False, True):
        assert not facing_inward(reversed_where(sheet, np.array(chosen))).any()
    count = 12
    angles = 2 * np.pi * np.arange(count) / count
    rims = [
        np.column_stack([(1 + w * np.cos(angles / 2)) * f(angles) for f in (np.cos, np.sin)] + [w * np.sin(angles / 2)])
        for w in (-0.3, 0.3)
    ]
    here, there = np.arange(count), (np.arange(count) + 1) % count
    last = there == 0
    near, far = np.where(last, there + count, there), np.where(last, there, there + count)
    faces = np.concatenate([np.stack([here, near, here + count], 1), np.stack([near, far, here + count], 1)])
    assert not facing_inward(Mesh(np.concatenate(rims), faces.astype(np.int32))).any()


def test_a_mixed_sheet_faces_where_most_of_it_does():
    x, y = np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    first = (np.arange(3)[:, None] * 4 + np.arange(3)).ravel()
    triangles = np.concatenate([np.stack([first, first + 4, first + 5], 1), np.stack([first, first + 5, first + 1], 1)])
    sheet = Mesh(points, triangles.astype(np.int32))
    chosen = np.isin(np.arange(18), [2, 5, 11])
    np.testing.assert_array_equal(facing_inward(reversed_where(sheet, chosen)), chosen)


def test_degenerate_meshes_are_left_alone():
    point = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32))
    needle = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]], np.int32))
    for mesh in (point, needle):
        assert not facing_inward(mesh).any()


@pytest.mark.parametrize("file", ["body_makehuman/base.obj", "sintel/sintel.obj", "sintel/sintel-eyes.obj"])
def test_real_bodies_are_left_as_they_are(shared, file):
    """With eyes, teeth, lashes, clothes and cubes at the joints; all parts are found if the file is inside out."""
    mesh = drop_unused(read_body(shared / file)).mesh
    assert not facing_inward(mesh).any()
    assert facing_inward(reversed_where(mesh, np.array(True))).all()


def test_texture_coordinates_stay_at_their_corners():
    uv = np.random.default_rng(1).random((len(BALL.triangles), 3, 2)).astype(np.float32)
    mesh = Mesh(BALL.points, BALL.triangles, uv=uv)
    once = reversed_where(mesh, np.array(True))
    at = {(p, tuple(t)) for p, t in zip(mesh.triangles.ravel(), uv.reshape(-1, 2), strict=True)}
    assert at == {(p, tuple(t)) for p, t in zip(once.triangles.ravel(), once.uv.reshape(-1, 2), strict=True)}


def write_obj(path, mesh: Mesh):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.points.tolist()]
    path.write_text("\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in (mesh.triangles + 1).tolist()), ""]))
    return path


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_hair_grows_outward_on_any_body(tmp_path, share):
    body = make_bust()
    chosen = np.random.default_rng(2).random(len(body.mesh.triangles)) < share
    file = write_obj(tmp_path / "bust.obj", reversed_where(body.mesh, chosen))
    if share == 0.0:
        loaded = load_body(file=file)
    else:
        with pytest.warns(UserWarning, match=rf"{chosen.sum():,} of 19,\d+ triangles of the body face inward"):
            loaded = load_body(file=file)
    np.testing.assert_array_equal(loaded.mesh.triangles, body.mesh.triangles)
    assert turned_outward(loaded) is loaded
    grooms = [grow_groom(one, strands=50) for one in (replace(loaded, maps=body.maps), body)]
    np.testing.assert_array_equal(*(groom.points for groom in grooms))
