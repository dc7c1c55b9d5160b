"""OpenVDB files hold what was baked, to the bit, and always in the same bytes."""

import importlib.util
import subprocess
import sys

import numpy as np
import pytest

from hairpipe.data import LevelSet, Mesh
from hairpipe.errors import BadInput
from hairpipe.levelset import vdb
from hairpipe.levelset.bake.whole import bake

VOXEL = 0.125


@pytest.fixture(scope="module")
def openvdb():
    try:
        return vdb.module()
    except BadInput as missing:
        pytest.skip(str(missing))


@pytest.fixture(scope="module")
def surface(sphere) -> LevelSet:
    mesh = sphere(1.0, (0.3, 1.0, -0.2), level=3)
    return bake(Mesh(mesh.points, mesh.triangles, np.cross([1.0, 2.0, 0.5], mesh.points)), VOXEL, 3.0)


@pytest.fixture
def written(openvdb, surface, tmp_path):
    path = tmp_path / "surface.0007.vdb"
    vdb.write(path, surface, 7)
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


def test_the_distance_comes_back_to_the_bit(openvdb, written, surface):
    band = np.maximum(surface.distance, np.float32(-3 * VOXEL))
    expected = everywhere(surface, band, 3 * VOXEL, -3 * VOXEL)
    assert (surface.bricks == LevelSet.FAR_INSIDE).any() or (surface.distance < -3 * VOXEL).any()
    assert np.array_equal(read_back(openvdb, written, surface, "surface", surface.distance), expected)


def test_the_velocity_comes_back_to_the_bit_in_the_band(openvdb, written, surface):
    banded = np.abs(surface.distance) < 3 * VOXEL
    expected = everywhere(surface, np.where(banded[..., None], surface.velocity, 0), 0, 0)
    assert np.array_equal(read_back(openvdb, written, surface, "vel", surface.velocity), expected)


def test_the_band_is_active_and_nothing_else(openvdb, written, surface):
    banded = (np.abs(surface.distance[:, :8, :8, :8]) < 3 * VOXEL).sum()
    assert openvdb.read(str(written), gridname="surface").activeVoxelCount() == banded
    assert openvdb.read(str(written), gridname="vel").activeVoxelCount() <= banded


def test_grids_lie_where_the_body_is(openvdb, written):
    points, quads = openvdb.read(str(written), gridname="surface").convertToQuads(isovalue=0.0)
    assert len(quads) > 100
    assert np.allclose(np.linalg.norm(points - [0.3, 1.0, -0.2], axis=1), 1.0, atol=0.2 * VOXEL)


def test_two_writes_are_the_same_bytes(openvdb, written, surface, tmp_path):
    vdb.write(tmp_path / "again.vdb", surface, 7)
    assert (tmp_path / "again.vdb").read_bytes() == written.read_bytes()
    vdb.write(tmp_path / "other.vdb", surface, 8)
    other = (tmp_path / "other.vdb").read_bytes()
    assert other[21:57] != written.read_bytes()[21:57]


def test_a_file_tells_class_and_metadata(openvdb, written):
    assert [(grid.name, grid.grid_class) for grid in vdb.inspect(written)] == [("surface", "level set"), ("vel", "")]
    band, vel = openvdb.readAllGridMetadata(str(written))
    assert np.allclose(band.transform.voxelSize(), VOXEL)
    assert (band["creator"], band["file_units"]) == ("hairpipe", "metres")
    assert (band["frame"], band["half_width"], band["voxel"]) == (7, 3.0, VOXEL)
    assert vel["vector_type"] == "contravariant relative"


def test_half_is_smaller_and_close(openvdb, written, surface, tmp_path):
    path = tmp_path / "half.vdb"
    vdb.write(path, surface, 7, half=True)
    assert path.stat().st_size < 0.9 * written.stat().st_size
    off = read_back(openvdb, path, surface, "surface", surface.distance) - everywhere(
        surface, np.maximum(surface.distance, np.float32(-3 * VOXEL)), 3 * VOXEL, -3 * VOXEL
    )
    assert np.abs(off).max() < 0.005 * VOXEL
    assert openvdb.readAllGridMetadata(str(path))[0].saveFloatAsHalf


def test_without_openvdb_the_message_names_the_extra(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(BadInput, match=r"not installed \(pip install 'hairpipe\[vdb\]'\)"):
        vdb.module.__wrapped__()


def test_pyopenvdb_is_refused_with_numpy_2(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name == "pyopenvdb" or None)
    monkeypatch.setattr(np, "__version__", "2.1.0")
    with pytest.raises(BadInput, match="crashes with numpy 2"):
        vdb.module.__wrapped__()


def test_nothing_is_said_at_exit_and_blender_is_not_started(openvdb, surface, tmp_path):
    code = (
        "import sys, numpy as np; from pathlib import Path; from hairpipe.data import LevelSet; "
        "from hairpipe.levelset import vdb; "
        "bricks = np.zeros((1, 1, 1), np.int32); d = np.zeros((1, 9, 9, 9), np.float32); "
        "s = LevelSet(bricks, d, np.zeros((1, 9, 9, 9, 3), np.float32), "
        "np.zeros((2, 2, 2, 4), np.float32), np.zeros(3), 0.1, 3.0); "
        "vdb.write(Path(sys.argv[1]), s, 1); assert 'bpy' not in sys.modules"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "a.vdb")], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
