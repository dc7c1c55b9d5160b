"""Baked distances, signs and velocities against closed forms."""

import warnings

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from hairpipe.errors import BadInput
from hairpipe.levelset.bake import bake
from hairpipe.values import LevelSet, Mesh

from ..conftest import positions, together, torus

HALF_WIDTH = 4.0


def spinning(mesh: Mesh, spin, travel=(0.0, 0.0, 0.0)) -> Mesh:
    return Mesh(mesh.points, mesh.triangles, np.cross(spin, mesh.points) + np.array(travel))


def baked(mesh: Mesh, voxel: float, half_width: float = HALF_WIDTH) -> LevelSet:
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
    exact, width = to_sphere(nine), voxel * HALF_WIDTH
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
    middle = np.abs(surface.distance) < (HALF_WIDTH - 1) * surface.voxel
    middle[:, [0, -1]] = middle[:, :, [0, -1]] = middle[:, :, :, [0, -1]] = False
    assert np.abs(slopes[middle] - 1).max() < 0.02
    assert np.abs(slopes[middle] - 1).mean() < 0.005


def test_the_velocity_is_that_of_the_closest_point(sphere):
    spin, travel = np.array([1.0, 2.0, -0.5]), np.array([0.3, 0.0, -0.2])
    surface = baked(spinning(sphere(level=4), spin, travel), 0.1)
    banded = np.abs(surface.distance) < 0.99 * HALF_WIDTH * surface.voxel
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
    banded, clear = np.abs(union) < (HALF_WIDTH - 0.1) * voxel, np.abs(union) > 0.05 * voxel
    assert ((surface.distance > 0) == (union > 0))[clear].all()
    assert np.abs(surface.distance - union)[(union > 0) & banded].max() < 0.05 * voxel
    # Inside, the surface is what shows of the spheres: here dots on them that are in no other sphere.
    dots = sphere(level=7).points
    shown = np.concatenate([dots[dots[:, 0] < 0.5], centre - dots[dots[:, 0] < 0.5]])
    depth, nearest = cKDTree(shown).query(points)
    inside = (union < 0) & (depth < (HALF_WIDTH - 0.1) * voxel)
    foot = shown[nearest]
    crease = np.hypot(foot[..., 0] - 0.5, np.linalg.norm(foot[..., 1:], axis=-1) - np.sqrt(0.75))
    off = np.abs(surface.distance + depth)
    assert off[inside].max() < 2.5 * voxel
    # A flap of 2.5 voxels behind the crease can be nearer than the surface as far as the band is wide.
    away = inside & (crease > (2.5 + 2 * HALF_WIDTH) * voxel)
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
        surface = bake(Mesh(mesh.points, mesh.triangles[2:]), 0.1, HALF_WIDTH)
    assert error(surface, to_box(positions(surface))) < 1e-5


def test_an_inside_out_body_is_the_same(sphere):
    mesh = sphere(level=2)
    flipped = Mesh(mesh.points, np.ascontiguousarray(mesh.triangles[:, ::-1]))
    assert np.allclose(baked(flipped, 0.1).distance, baked(mesh, 0.1).distance)


def test_a_body_too_thin_for_the_voxel_is_refused_or_reported(box):
    sheet = box((1.0, -0.5, 0.01), (2.0, 0.5, 0.02))
    with pytest.raises(BadInput, match=r"encloses no sample at voxel = 0.1 m \(a smaller voxel\)"):
        bake(sheet, 0.1, HALF_WIDTH)
    with pytest.warns(UserWarning, match="25% of the surface is too thin for voxel = 0.1 m"):
        bake(together(box(), sheet), 0.1, HALF_WIDTH)


@pytest.mark.parametrize("voxel", [0.1])
def test_openvdb_agrees_but_for_its_own_error(openvdb, sphere, voxel):
    mesh = sphere(level=4)
    theirs = openvdb.FloatGrid.createLevelSetFromPolygons(
        mesh.points.astype(np.float32),
        triangles=mesh.triangles.astype(np.uint32),
        transform=openvdb.createLinearTransform(voxelSize=voxel),
        halfWidth=HALF_WIDTH,
    )
    ours = baked(mesh, voxel)
    for place in np.argwhere(ours.bricks >= 0):
        block = np.empty((9, 9, 9), np.float32)
        theirs.copyToArray(block, ijk=tuple((np.rint(ours.origin / voxel).astype(int) + 8 * place).tolist()))
        band = np.maximum(ours.distance[ours.bricks[tuple(place)]], -HALF_WIDTH * voxel)
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
        surface = bake(mesh, voxel, HALF_WIDTH)
    assert sum("capped 6 holes: 46 edges" in str(one.message) for one in reported) == (open_edges > 0)
    full = (surface.bricks == LevelSet.FAR_INSIDE).sum() * 8**3 + (surface.distance[:, :8, :8, :8] < 0).sum()
    assert full * voxel**3 == pytest.approx(volume, rel=0.05)
