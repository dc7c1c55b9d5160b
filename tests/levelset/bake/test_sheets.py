"""Sheets of a thickness, alone and over a body, against brute-force distances to triangles."""

import numpy as np
import pytest

from hairpipe.body.shapes import build_cylinder
from hairpipe.errors import BadInput
from hairpipe.geometry.collider import SdfSample
from hairpipe.levelset.bake import bake, bake_sheets, split_pieces
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.sample import Interpolation, distance, field_of, gradient
from hairpipe.values import LevelSet, Mesh

from ..conftest import positions, together

VOXEL, HALF_WIDTH = 0.01, 6.0
WIDTH = VOXEL * HALF_WIDTH


def brute(points: np.ndarray, mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Distance of points (n, 3) to the triangles of a mesh, and the velocity of the closest point."""
    best, rates = np.full(len(points), np.inf), np.zeros((len(points), 3))
    for corners, speeds in zip(mesh.points[mesh.triangles], mesh.rates[mesh.triangles], strict=True):
        a, b, c = corners
        basis = np.stack([b - a, c - a], axis=1)
        inner = np.linalg.lstsq(basis, (points - a).T, rcond=None)[0].T
        weights = [np.column_stack([1.0 - inner.sum(axis=1), inner])]
        for i, j in ((0, 1), (1, 2), (2, 0)):
            way = corners[j] - corners[i]
            share = np.clip((points - corners[i]) @ way / (way @ way), 0.0, 1.0)
            on_edge = np.zeros((len(points), 3))
            on_edge[:, i], on_edge[:, j] = 1.0 - share, share
            weights.append(on_edge)
        for number, weight in enumerate(weights):
            valid = (weight >= 0.0).all(axis=1) if number == 0 else np.ones(len(points), bool)
            far = np.linalg.norm(points - weight @ corners, axis=1)
            nearer = valid & (far < best - 1e-12)
            best[nearer], rates[nearer] = far[nearer], (weight @ speeds)[nearer]
    return best, rates


def collar(radius: float = 0.13, height: float = 0.1, widening: float = 1.2, around: int = 24) -> Mesh:
    """A turning open cylinder about Y, from the ground up."""
    angles = 2.0 * np.pi * np.arange(around) / around
    low = np.column_stack([radius * np.cos(angles), np.zeros(around), radius * np.sin(angles)])
    points = np.concatenate([low, low * (widening, 1.0, widening) + (0.0, height, 0.0)])
    here = np.arange(around)
    there = np.roll(here, -1)
    lower, upper = (
        np.column_stack([here, there, here + around]),
        np.column_stack([there, there + around, here + around]),
    )
    return Mesh(points, np.concatenate([lower, upper]).astype(np.int32), np.cross([0.0, 3.0, 0.0], points))


def read(surface: LevelSet, points: np.ndarray) -> np.ndarray:
    field = field_of(surface)
    return np.array([distance(field, *point) for point in points])


@pytest.mark.parametrize("thickness", [0.02, 0.03])
def test_a_collar_is_within_half_a_thickness_of_its_triangles(thickness):
    mesh = collar()
    surface = bake_sheets(None, mesh, VOXEL, HALF_WIDTH, "fill", thickness)
    points = positions(surface)
    exact, rates = brute(points.reshape(-1, 3), mesh)
    exact = exact.reshape(points.shape[:-1])
    np.testing.assert_allclose(surface.distance, np.minimum(exact - 0.5 * thickness, WIDTH), atol=1e-7)
    known = np.hypot(points[..., 0], points[..., 2]) > 0.16  # where one triangle is nearest, also beyond the band
    off = np.linalg.norm(surface.velocity - rates.reshape(points.shape), axis=-1)
    assert known.sum() > 1000 and off[known].max() < 1e-6
    assert not (surface.bricks == LevelSet.FAR_INSIDE).any()
    axis = np.column_stack([np.zeros(5), np.linspace(0.0, 0.1, 5), np.zeros(5)])
    assert (read(surface, axis) == np.float32(WIDTH)).all()  # the inside of a collar is free


def test_the_middle_of_the_thinnest_sheet_is_inside():
    mesh = collar()
    weights = np.random.default_rng(1).dirichlet(np.ones(3), (len(mesh.triangles), 40))
    middle = np.einsum("mkw,mwx->mkx", weights, mesh.points[mesh.triangles]).reshape(-1, 3)
    assert (read(bake_sheets(None, mesh, VOXEL, HALF_WIDTH, "fill", None), middle) < 0.0).all()


def test_winding_has_no_effect():
    mesh = collar()
    turned = mesh.triangles.copy()
    turned[::3] = turned[::3, ::-1]
    surfaces = [
        bake_sheets(None, Mesh(mesh.points, t), VOXEL, HALF_WIDTH, "fill", None) for t in (mesh.triangles, turned)
    ]
    np.testing.assert_allclose(surfaces[1].distance, surfaces[0].distance, atol=1e-7)


def test_a_head_in_a_collar_is_one_collider(sphere):
    head, around = sphere(0.1, (0.0, 0.05, 0.0), 4), collar(0.14)
    surface = bake_sheets(head, around, VOXEL, HALF_WIDTH, "refuse", 0.02)
    points = positions(surface).reshape(-1, 3)
    near = np.abs(points[:, 1] - 0.05) < 0.08
    solid = read(bake(head, VOXEL, HALF_WIDTH), points[near])
    apart = np.minimum(solid, brute(points[near], around)[0] - 0.01)
    found = surface.distance.reshape(-1)[near]
    np.testing.assert_allclose(np.minimum(found, WIDTH), np.minimum(apart, WIDTH), atol=1e-6)
    between = read(surface, np.array([[0.115, 0.05, 0.0], [0.0, 0.05, -0.115]]))
    assert (between > 0.0).all()  # hair has its place between the two


@pytest.mark.parametrize("above", [-0.004, 0.0, 0.004, 0.008])
def test_the_way_out_of_skin_is_across_a_garment_that_lies_on_it(above):
    skin = build_cylinder(0.1, 0.4, False, 64, (0.0, 0.05, 0.0), (0.0, 1.0, 0.0))
    garment = collar(0.1 + above, 0.1, 1.0, 64)
    surface = bake_sheets(skin, garment, VOXEL, HALF_WIDTH, "refuse", 0.024)
    radii = np.linspace(0.06, 0.15, 46)
    points = np.column_stack([radii, np.full(46, 0.05), np.full(46, 0.002)])
    np.testing.assert_allclose(read(surface, points), np.minimum(radii - (0.1 + above + 0.012), WIDTH), atol=1.5e-3)
    field = field_of(surface)
    normals = np.array([gradient(field, *point) for point in points[radii < 0.14]])
    assert (normals[:, 0] > 0.9).all()
    free = read(surface, points + np.array([0.0, 0.12, 0.0]))
    np.testing.assert_allclose(free, np.minimum(radii - 0.1, WIDTH), atol=1.5e-3)


def test_a_garment_off_the_skin_has_two_sides():
    skin = build_cylinder(0.1, 0.4, False, 64, (0.0, 0.05, 0.0), (0.0, 1.0, 0.0))
    surface = bake_sheets(skin, collar(0.13, 0.1, 1.0, 64), VOXEL, HALF_WIDTH, "refuse", 0.02)
    inner, outer = (gradient(field_of(surface), r, 0.05, 0.002)[0] for r in (0.125, 0.135))
    assert inner < -0.9 and outer > 0.9
    skin_side, middle, sheet_side = read(surface, np.array([[r, 0.05, 0.002] for r in (0.103, 0.11, 0.117)]))
    assert 0.0 < skin_side < middle > sheet_side > 0.0


def test_a_garment_that_crosses_its_band_over_a_body_is_found_between_frames():
    """A cloth of 2 cm, 10.5 cm above a table, moves across itself by 10 cm, with a band of 6 cm."""
    table = build_cylinder(0.3, 0.2, False, 24, (0.0, -0.06, 0.0), (0.0, 1.0, 0.0))
    frame, way, speed = 0.04, 0.1, 2.5
    surfaces = []
    for x in (-0.5 * way, 0.5 * way):
        corners = np.array([[x, y, z] for y in (0.145, 0.158) for z in (-0.05, 0.05)])
        cloth = Mesh(corners, np.array([[0, 1, 2], [1, 3, 2]], np.int32), np.tile([speed, 0.0, 0.0], (4, 1)))
        surfaces.append(bake_sheets(table, cloth, VOXEL, HALF_WIDTH, "refuse", 0.02))
    body = build_collider_field(*surfaces, frame, Interpolation.two_sided)
    assert body.lost == 0.0
    for seconds in np.array([0.25, 0.5, 0.75]) * frame:
        found = SdfSample.blank(3)
        places = np.array([[speed * seconds - 0.5 * way + side, 0.15, 0.0] for side in (-0.02, 0.0, 0.02)])
        body.probe(places, seconds, found)
        np.testing.assert_allclose(found.distance, [0.01, -0.01, 0.01], atol=1e-3)
        np.testing.assert_allclose(found.velocity, np.tile([speed, 0.0, 0.0], (3, 1)), rtol=1e-5)


def test_velocities_beyond_the_bands_are_those_of_the_nearer_of_sheet_and_body():
    table = build_cylinder(0.15, 0.2, False, 24, (0.0, -0.06, 0.0), (0.0, 1.0, 0.0))
    corners = np.array([[0.02, y, z] for y in (0.16, 0.2) for z in (-0.05, 0.05)])
    cloth = Mesh(corners, np.array([[0, 1, 2], [1, 3, 2]], np.int32), np.tile([2.0, 0.0, 0.0], (4, 1)))
    surface = bake_sheets(table, cloth, VOXEL, HALF_WIDTH, "refuse", 0.02)
    points = positions(surface).reshape(-1, 3)[::7]
    to_cloth, to_table = (brute(points, mesh)[0] for mesh in (cloth, table))
    beyond = (np.minimum(to_cloth - 0.01, to_table) > WIDTH) & (np.abs(to_cloth - to_table) > 1e-9)
    rates = surface.velocity.reshape(-1, 3)[::7][beyond, 0]
    nearer = (to_cloth < to_table)[beyond]
    assert min(nearer.sum(), (~nearer).sum()) > 100
    np.testing.assert_array_equal(rates, np.where(nearer, np.float32(2.0), np.float32(0.0)))


def test_closed_pieces_of_sheets_are_solid(sphere):
    ball = sphere(0.08, (0.0, 0.35, 0.0), 3)
    surface = bake_sheets(None, together(ball, collar()), VOXEL, HALF_WIDTH, "refuse", None)
    places = np.column_stack([np.zeros(9), np.linspace(0.29, 0.45, 9), np.zeros(9)])
    np.testing.assert_allclose(read(surface, places), read(bake(ball, VOXEL, HALF_WIDTH), places), atol=1e-6)
    alone = bake_sheets(None, ball, VOXEL, HALF_WIDTH, "refuse", None)
    np.testing.assert_allclose(read(alone, places), read(surface, places), atol=1e-6)


def test_pieces_end_where_three_triangles_meet(box):
    solid = box()
    fin = np.array([[0.5, 0.5, -0.5], [0.5, 0.5, 0.5], [0.9, 0.5, 0.0]])
    points = np.concatenate([solid.points, fin])
    mesh = Mesh(points, np.concatenate([solid.triangles, [[8, 9, 10]]]).astype(np.int32))
    closed, sheets = split_pieces(mesh)
    np.testing.assert_array_equal(closed.triangles, solid.triangles)
    np.testing.assert_array_equal(sheets.triangles, [[8, 9, 10]])


def test_lashes_of_an_artist_stop_hair(shared):
    from hairpipe.formats.obj import read_polygons

    lashes, bust = (
        read_polygons(shared / "sintel" / name).mesh for name in ("sintel-eyelashes.obj", "sintel-collider.obj")
    )
    assert not len(split_pieces(lashes)[0].triangles)
    surface = bake_sheets(bust, lashes, 0.002, 8.0, "fill", 0.004)
    middles = lashes.points[lashes.triangles].mean(axis=1)
    assert (read(surface, middles) < 0.0).all()


@pytest.mark.parametrize("thickness", [0.019, 0.121])
def test_a_thickness_beyond_the_samples_is_refused(thickness):
    with pytest.raises(BadInput, match=rf"sheets are {thickness:g} m thick \(0.02 to 0.12"):
        bake_sheets(None, collar(), VOXEL, HALF_WIDTH, "fill", thickness)


def test_sheets_do_not_depend_on_threads(sphere, same_on_threads):
    same_on_threads(lambda: bake_sheets(sphere(0.1, level=3), collar(), VOXEL, HALF_WIDTH, "fill", None))
