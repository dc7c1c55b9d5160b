"""OpenVDB files hold what was baked, to the bit as OpenVDB reads them, and always in the same bytes."""

import hashlib

import numpy as np
import pytest

from hairpipe.formats import vdb
from hairpipe.formats.vdb import density_grids, inspect, surface_grids
from hairpipe.levelset.bake import bake
from hairpipe.values import Density, LevelSet, Mesh

VOXEL = 0.125


@pytest.fixture(scope="module")
def surface(sphere) -> LevelSet:
    mesh = sphere(1.0, (0.3, 1.0, -0.2), level=3)
    return bake(Mesh(mesh.points, mesh.triangles, np.cross([1.0, 2.0, 0.5], mesh.points)), VOXEL, 3.0)


@pytest.fixture
def written(surface, tmp_path):
    path = tmp_path / "surface.0007.vdb"
    vdb.write(path, surface_grids(surface), 7)
    return path


def read_back(openvdb, path, surface: LevelSet, name: str, values: np.ndarray) -> np.ndarray:
    """The values of all places of the lattice's bricks, far ones too, (na, nb, nc, 9, 9, 9, ...)."""
    grid = openvdb.read(str(path), gridname=name)
    first = np.rint(surface.origin / surface.voxel).astype(int)
    found = np.empty(surface.bricks.shape + values.shape[1:], np.float32)
    for place in np.ndindex(surface.bricks.shape):
        grid.copyToArray(found[place], ijk=tuple((first + 8 * np.array(place)).tolist()))
    return found


def everywhere(surface: LevelSet, values: np.ndarray, outside: float, inside: float) -> np.ndarray:
    found = values[surface.bricks]
    found[surface.bricks == LevelSet.FAR_OUTSIDE] = outside
    found[surface.bricks == LevelSet.FAR_INSIDE] = inside
    return found


def test_the_distance_is_read_back_to_the_bit(openvdb, written, surface):
    band = np.maximum(surface.distance, np.float32(-3 * VOXEL))
    expected = everywhere(surface, band, 3 * VOXEL, -3 * VOXEL)
    assert (surface.bricks == LevelSet.FAR_INSIDE).any() or (surface.distance < -3 * VOXEL).any()
    assert np.array_equal(read_back(openvdb, written, surface, "surface", surface.distance), expected)


def test_the_velocity_is_read_back_to_the_bit_in_the_band(openvdb, written, surface):
    banded = np.abs(surface.distance) < 3 * VOXEL
    expected = everywhere(surface, np.where(banded[..., None], surface.velocity, 0), 0, 0)
    assert np.array_equal(read_back(openvdb, written, surface, "vel", surface.velocity), expected)


def test_the_band_is_active_and_nothing_else(openvdb, written, surface):
    banded = (np.abs(surface.distance[:, :8, :8, :8]) < 3 * VOXEL).sum()
    assert openvdb.read(str(written), gridname="surface").activeVoxelCount() == banded
    assert openvdb.read(str(written), gridname="vel").activeVoxelCount() <= banded


def test_a_far_place_outside_is_background_and_one_inside_its_negative(openvdb, tmp_path):
    """A cube of 20^3 blocks that are all inside, across nodes of 16^3 and the origin, with leaves on one side only."""
    bricks = np.full((22, 22, 22), LevelSet.FAR_OUTSIDE, np.int32)
    bricks[1:21, 1:21, 1:21] = LevelSet.FAR_INSIDE
    bricks[0] = np.arange(22 * 22).reshape(22, 22)
    distance = np.linspace(0.3, -0.3, 9, dtype=np.float32)[None, :, None, None] + np.zeros((484, 9, 9, 9), np.float32)
    velocity, inner = np.zeros((484, 9, 9, 9, 3), np.float32), np.zeros((23, 23, 23, 4), np.float32)
    surface = LevelSet(bricks, distance, velocity, inner, np.full(3, -8.0), 0.1, 2.0)
    vdb.write(tmp_path / "cube.vdb", surface_grids(surface), 1)
    found = read_back(openvdb, tmp_path / "cube.vdb", surface, "surface", distance)[..., :8, :8, :8]
    assert np.array_equal(found, everywhere(surface, distance, 0.2, -0.2)[..., :8, :8, :8].clip(-0.2, 0.2))
    assert openvdb.read(str(tmp_path / "cube.vdb"), gridname="vel").activeVoxelCount() == 0


def test_the_bytes_depend_on_neither_python_nor_library(tmp_path):
    """OpenVDB 12 and 13 read back what this file was made of."""
    distance = np.linspace(-0.3, 0.3, 9, dtype=np.float32)[None, :, None, None] + np.zeros((1, 9, 9, 9), np.float32)
    velocity, inner = np.ones((1, 9, 9, 9, 3), np.float32), np.zeros((2, 2, 2, 4), np.float32)
    brick = LevelSet(np.zeros((1, 1, 1), np.int32), distance, velocity, inner, np.zeros(3), 0.1, 3.0)
    vdb.write(tmp_path / "a.vdb", surface_grids(brick), 7)
    assert hashlib.sha256((tmp_path / "a.vdb").read_bytes()).hexdigest()[:16] == "df3674368087433b"


def test_grids_lie_where_the_body_is(openvdb, written):
    points, quads = openvdb.read(str(written), gridname="surface").convertToQuads(isovalue=0.0)
    assert len(quads) > 100
    assert np.allclose(np.linalg.norm(points - [0.3, 1.0, -0.2], axis=1), 1.0, atol=0.2 * VOXEL)


def test_two_writes_are_the_same_bytes(written, surface, tmp_path):
    vdb.write(tmp_path / "again.vdb", surface_grids(surface), 7)
    assert (tmp_path / "again.vdb").read_bytes() == written.read_bytes()
    vdb.write(tmp_path / "other.vdb", surface_grids(surface), 8)
    other = (tmp_path / "other.vdb").read_bytes()
    assert other[21:57] != written.read_bytes()[21:57]


def test_class_and_metadata_are_read(openvdb, written):
    assert [(grid.name, grid.grid_class) for grid in inspect(written)] == [("surface", "level set"), ("vel", "")]
    band, vel = openvdb.readAllGridMetadata(str(written))
    assert np.allclose(band.transform.voxelSize(), VOXEL)
    assert (band["creator"], band["file_units"]) == ("hairpipe", "metres")
    assert (band["frame"], band["half_width"], band["voxel"]) == (7, 3.0, VOXEL)
    assert vel["vector_type"] == "contravariant relative"


def test_half_is_smaller_and_close(openvdb, written, surface, tmp_path):
    path = tmp_path / "half.vdb"
    vdb.write(path, surface_grids(surface), 7, half=True)
    assert path.stat().st_size < 0.9 * written.stat().st_size
    off = read_back(openvdb, path, surface, "surface", surface.distance) - everywhere(
        surface, np.maximum(surface.distance, np.float32(-3 * VOXEL)), 3 * VOXEL, -3 * VOXEL
    )
    assert np.abs(off).max() < 0.005 * VOXEL
    assert openvdb.readAllGridMetadata(str(path))[0].saveFloatAsHalf


@pytest.mark.parametrize("low", [(-5, 3, 16), (0, -8, -1)])
def test_a_density_is_read_back_to_the_bit_where_it_lies(openvdb, tmp_path, low):
    rng, path = np.random.default_rng(3), tmp_path / "density.vdb"
    length = np.maximum(rng.normal(size=(11, 9, 20)), 0.0).astype(np.float32)
    velocity = np.where(length[..., None] > 0.0, rng.normal(size=(11, 9, 20, 3)), 0.0).astype(np.float32)
    vdb.write(path, density_grids(Density(np.array(low, np.int32), 0.01, length, velocity)), 3)
    for name, values in (("density", length), ("hair_vel", velocity)):
        grid, found = openvdb.read(str(path), gridname=name), np.empty((20, 20, 30, *values.shape[3:]), np.float32)
        grid.copyToArray(found, ijk=tuple(int(i) - 4 for i in low))
        expected = np.zeros_like(found)
        expected[4:15, 4:13, 4:24] = values
        np.testing.assert_array_equal(found, expected)
        assert grid.activeVoxelCount() == np.count_nonzero(length)
        assert grid.transform.voxelSize()[0] == 0.01
