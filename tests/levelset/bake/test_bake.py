"""Baked distances, signs and velocities of bodies and of sheets."""

import warnings

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from hairpipe.body.shapes import build_cylinder
from hairpipe.errors import BadInput
from hairpipe.geometry.collider import SdfSample
from hairpipe.levelset.bake import bake, bake_sheets, split_pieces
from hairpipe.levelset.collider_field import build_collider_field
from hairpipe.levelset.sample import Interpolation, distance, field_of, gradient
from hairpipe.values import LevelSet, Mesh

from ..conftest import positions, together, torus

BAND = 4.0


def spinning(mesh: Mesh, spin, travel=(0.0, 0.0, 0.0)) -> Mesh:
    return Mesh(mesh.points, mesh.triangles, np.cross(spin, mesh.points) + np.array(travel))


def baked(mesh: Mesh, voxel: float, half_width: float = BAND) -> LevelSet:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return bake(mesh, voxel, half_width, "refuse")


def to_sphere(points, radius=1.0, centre=(0.0, 0.0, 0.0)):
    return np.linalg.norm(points - np.array(centre), axis=-1) - radius


def to_box(points, half=0.5):
    q = np.abs(points) - half
    return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(axis=-1), 0)


def to_torus(points, radius, tube):
    ring = np.linalg.norm(points[..., [0, 2]], axis=-1) - radius
    return np.hypot(ring, points[..., 1]) - tube


def error(surface: LevelSet, exact: np.ndarray) -> float:
    """Largest error of the samples of the band [voxel]."""
    width = surface.voxel * surface.half_width
    return np.abs(np.clip(surface.distance, -width, width) - np.clip(exact, -width, width)).max() / surface.voxel


@pytest.mark.parametrize("voxel", [0.1, 0.07])
def test_a_box_is_exact(box, voxel):
    surface = baked(box(), voxel)
    assert error(surface, to_box(positions(surface))) < 1e-5


def test_a_turned_box_is_exact(box):
    mesh, turn = box(), Rotation.from_rotvec([0.3, -0.8, 0.5])
    surface = baked(Mesh(turn.apply(mesh.points), mesh.triangles), 0.09)
    points = positions(surface)
    assert error(surface, to_box(points @ turn.as_matrix())) < 1e-5


@pytest.mark.parametrize("level", [3, 4, 5])
def test_a_sphere_to_the_error_of_its_mesh(sphere, level):
    mesh, voxel = sphere(level=level), 0.1
    a, b, c = mesh.points[mesh.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    flattest = 1 - (np.einsum("tj,tj->t", normals, a) / np.linalg.norm(normals, axis=1)).min()
    surface = baked(mesh, voxel)
    # The polyhedron lies within the sphere, by that much where a face is farthest from it.
    assert error(surface, to_sphere(positions(surface))) < flattest / voxel + 1e-5


def test_a_torus_to_the_error_of_its_mesh():
    surface = baked(torus(1.0, 0.4), 0.08)
    assert error(surface, to_torus(positions(surface), 1.0, 0.4)) < 0.03


def test_samples_lie_on_the_world_lattice(sphere):
    surface = baked(sphere(0.3, (0.5, -0.2, 0.1), 2), 0.04)
    steps = surface.origin / 0.04
    assert np.allclose(steps, 8 * np.rint(steps / 8), atol=1e-9)
    shifted = baked(sphere(0.3, (0.5 + 0.32, -0.2, 0.1), 2), 0.04)
    assert np.allclose(shifted.distance, surface.distance, atol=1e-6)


def test_bricks_cover_the_band_and_nothing_else(sphere):
    voxel = 0.05
    surface = baked(sphere(level=4), voxel)
    corner = surface.origin + 8 * voxel * np.stack(
        np.meshgrid(*map(np.arange, surface.bricks.shape), indexing="ij"), -1
    )
    nine = corner[..., None, :] + voxel * np.stack(np.meshgrid(*[np.arange(9)] * 3, indexing="ij"), -1).reshape(-1, 3)
    exact, width = to_sphere(nine), voxel * BAND
    tolerance = 0.02 * voxel
    stored = surface.bricks >= 0
    assert (np.abs(exact).min(axis=-1)[stored] < width + tolerance).all()
    assert (np.abs(exact).min(axis=-1)[~stored] > width - tolerance).all()
    assert (exact[surface.bricks == LevelSet.FAR_OUTSIDE] > 0).all()
    assert (exact[surface.bricks == LevelSet.FAR_INSIDE] < 0).all()
    assert (surface.bricks == LevelSet.FAR_INSIDE).any()
    assert sorted(surface.bricks[stored]) == list(range(len(surface.distance)))


def test_bricks_agree_on_the_samples_they_share(sphere):
    surface = baked(spinning(sphere(level=3), [0.3, 1, 2]), 0.06)
    pairs = 0
    for axis in range(3):
        before, after = (np.moveaxis(surface.bricks, axis, 0)[part] for part in (slice(-1), slice(1, None)))
        both = (before >= 0) & (after >= 0)
        for field in (surface.distance, surface.velocity):
            last, first = (np.moveaxis(field, axis + 1, 1)[:, i] for i in (8, 0))
            assert np.array_equal(last[before[both]], first[after[both]])
        pairs += both.sum()
    assert pairs > 50


def test_the_gradient_is_one_in_the_band(sphere):
    surface = baked(sphere(level=5), 0.05)
    slopes = np.linalg.norm(np.gradient(surface.distance.astype(float), surface.voxel, axis=(1, 2, 3)), axis=0)
    middle = np.abs(surface.distance) < (BAND - 1) * surface.voxel
    middle[:, [0, -1]] = middle[:, :, [0, -1]] = middle[:, :, :, [0, -1]] = False
    assert np.abs(slopes[middle] - 1).max() < 0.02
    assert np.abs(slopes[middle] - 1).mean() < 0.005


def test_the_velocity_is_that_of_the_closest_point(sphere):
    spin, travel = np.array([1.0, 2.0, -0.5]), np.array([0.3, 0.0, -0.2])
    surface = baked(spinning(sphere(level=4), spin, travel), 0.1)
    banded = np.abs(surface.distance) < 0.99 * BAND * surface.voxel
    points = positions(surface)[banded]
    nearest = points / np.linalg.norm(points, axis=-1, keepdims=True)
    off = np.linalg.norm(surface.velocity[banded] - np.cross(spin, nearest) - travel, axis=-1)
    # On a polyhedron the closest point is off to the side by up to the distance times the angle between two faces.
    assert off.max() < np.linalg.norm(spin) * 0.4 * 0.12
    assert off.mean() < np.linalg.norm(spin) * 0.01


def test_samples_outside_the_band_have_the_velocity_of_the_nearest_part(sphere):
    """Two spheres, one at rest and a fast one: whichever of them the search begins with, it is not what is found."""
    still = sphere(0.3, level=3)
    for side in (-1.0, 1.0):
        mesh = together(still, sphere(0.3, (side, 0.2 * side, 0.1 * side), 3))
        speeds = np.repeat([[0.0, 0, 0], [5.0, 0, 0]], len(still.points), axis=0)
        surface = baked(Mesh(mesh.points, mesh.triangles, speeds), 0.05, 2.0)
        points = positions(surface)
        to_fast = to_sphere(points, 0.3, (side, 0.2 * side, 0.1 * side)) - to_sphere(points, 0.3)
        nearer = np.abs(to_fast) > 0.05
        assert np.allclose(surface.velocity[nearer & (to_fast > 0)], 0.0)
        assert np.allclose(surface.velocity[nearer & (to_fast < 0)], [5.0, 0.0, 0.0])


def test_the_velocity_of_a_face_is_interpolated_in_it(box):
    surface = baked(spinning(box(), [0.0, 1.0, 0.0]), 0.1)
    points = positions(surface)
    above = (np.abs(points[..., [0, 2]]) < 0.49).all(axis=-1) & (points[..., 1] > 0.51) & (points[..., 1] < 0.85)
    assert above.sum() > 100
    feet = points[above] * [1, 0, 1] + [0, 0.5, 0]
    assert np.allclose(surface.velocity[above], np.cross([0, 1.0, 0], feet), atol=1e-6)


def test_overlapping_parts_are_their_union(sphere):
    voxel, centre = 0.08, np.array([1.0, 0.0, 0.0])
    mesh = together(sphere(level=4), sphere(centre=centre, level=4))
    speed = np.repeat([[1.0, 0, 0], [0, 2.0, 0]], len(mesh.points) // 2, axis=0)
    surface = baked(Mesh(mesh.points, mesh.triangles, speed), voxel)
    points = positions(surface)
    union = np.minimum(to_sphere(points), to_sphere(points, 1.0, centre))
    banded, clear = np.abs(union) < (BAND - 0.1) * voxel, np.abs(union) > 0.05 * voxel
    assert ((surface.distance > 0) == (union > 0))[clear].all()
    assert np.abs(surface.distance - union)[(union > 0) & banded].max() < 0.05 * voxel
    # Inside, the surface is what shows of the spheres: here dots on them that are in no other sphere.
    dots = sphere(level=7).points
    shown = np.concatenate([dots[dots[:, 0] < 0.5], centre - dots[dots[:, 0] < 0.5]])
    depth, nearest = cKDTree(shown).query(points)
    inside = (union < 0) & (depth < (BAND - 0.1) * voxel)
    foot = shown[nearest]
    crease = np.hypot(foot[..., 0] - 0.5, np.linalg.norm(foot[..., 1:], axis=-1) - np.sqrt(0.75))
    off = np.abs(surface.distance + depth)
    assert off[inside].max() < 2.5 * voxel
    # A flap of 2.5 voxels behind the crease can be nearer than the surface as far as the band is wide.
    away = inside & (crease > (2.5 + 2 * BAND) * voxel)
    assert away.sum() > 100
    assert off[away].max() < 0.25 * voxel
    assert np.allclose(surface.velocity[away & (foot[..., 0] < 0.5)], [1.0, 0, 0])
    assert np.allclose(surface.velocity[away & (foot[..., 0] > 0.5)], [0, 2.0, 0])


def test_the_result_does_not_depend_on_threads(sphere, same_on_threads):
    mesh = spinning(sphere(level=3), [1, 2, 3])
    same_on_threads(lambda: baked(mesh, 0.07))


def test_an_open_body_is_that_with_a_cap(box):
    mesh = box()
    with pytest.warns(UserWarning, match="capped 1 hole"):
        surface = bake(Mesh(mesh.points, mesh.triangles[2:]), 0.1, BAND)
    assert error(surface, to_box(positions(surface))) < 1e-5


def test_an_inside_out_body_is_the_same(sphere):
    mesh = sphere(level=2)
    flipped = Mesh(mesh.points, np.ascontiguousarray(mesh.triangles[:, ::-1]))
    assert np.allclose(baked(flipped, 0.1).distance, baked(mesh, 0.1).distance)


def test_a_body_too_thin_for_the_voxel_is_refused_or_reported(box):
    sheet = box((1.0, -0.5, 0.01), (2.0, 0.5, 0.02))
    with pytest.raises(BadInput, match=r"encloses no sample at voxel = 0.1 m \(a smaller voxel\)"):
        bake(sheet, 0.1, BAND)
    with pytest.warns(UserWarning, match="25% of the surface is too thin for voxel = 0.1 m"):
        bake(together(box(), sheet), 0.1, BAND)


@pytest.mark.parametrize("voxel", [0.1])
def test_openvdb_agrees_but_for_its_own_error(openvdb, sphere, voxel):
    mesh = sphere(level=4)
    theirs = openvdb.FloatGrid.createLevelSetFromPolygons(
        mesh.points.astype(np.float32),
        triangles=mesh.triangles.astype(np.uint32),
        transform=openvdb.createLinearTransform(voxelSize=voxel),
        halfWidth=BAND,
    )
    ours = baked(mesh, voxel)
    for place in np.argwhere(ours.bricks >= 0):
        block = np.empty((9, 9, 9), np.float32)
        theirs.copyToArray(block, ijk=tuple((np.rint(ours.origin / voxel).astype(int) + 8 * place).tolist()))
        band = np.maximum(ours.distance[ours.bricks[tuple(place)]], -BAND * voxel)
        assert np.abs(block - band).max() < 0.6 * voxel


@pytest.mark.parametrize(
    ("name", "voxel", "volume", "open_edges"),
    [("sintel.obj", 0.01, 0.0092, 148), ("sintel-collider.obj", 0.01, 0.00498, 0)],
)
def test_real_bodies(shared, name, voxel, volume, open_edges):
    from hairpipe.formats.obj import read_polygons

    mesh = read_polygons(shared / "sintel" / name).mesh
    with warnings.catch_warnings(record=True) as reported:
        warnings.simplefilter("always")
        surface = bake(mesh, voxel, BAND)
    assert sum("capped 6 holes: 46 edges" in str(one.message) for one in reported) == (open_edges > 0)
    full = (surface.bricks == LevelSet.FAR_INSIDE).sum() * 8**3 + (surface.distance[:, :8, :8, :8] < 0).sum()
    assert full * voxel**3 == pytest.approx(volume, rel=0.05)


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
    faces = [[here, there, here + around], [there, there + around, here + around]]
    return Mesh(points, np.concatenate(np.moveaxis(faces, 1, 2)).astype(np.int32), np.cross([0.0, 3.0, 0.0], points))


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
