"""OpenVDB files: headers, voxels as they are stored, and what was baked, to the bit."""

import contextlib
import dataclasses
import struct
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hairpipe.errors import BadInput
from hairpipe.formats import vdb
from hairpipe.formats.vdb import box, density_grids, inspect, read_here, surface_grids
from hairpipe.levelset.bake import bake
from hairpipe.values import Density, LevelSet, Mesh
from hairpipe.volume.density import density_of_voxels


def text(value: str) -> bytes:
    return struct.pack("<I", len(value.encode())) + value.encode()


def entry(name: str, kind: str, data: bytes) -> bytes:
    return text(name) + text(kind) + struct.pack("<I", len(data)) + data


def metadata(*entries: bytes) -> bytes:
    return struct.pack("<I", len(entries)) + b"".join(entries)


def header(version: int = 224, offsets: bool = True) -> bytes:
    start = struct.pack("<qIII?", 0x56444220, version, 12, 0, offsets) + b"0" * 36
    return start + metadata(entry("creator", "string", b"somebody"))


def grid(at: int, name: str, kind: str, transform: bytes, *entries: bytes, voxels: bytes = b"v" * 50) -> bytes:
    """A grid that begins at a byte of the file."""
    descriptor = text(name) + text(kind) + text("")
    start = at + len(descriptor) + 24
    body = struct.pack("<I", 0) + metadata(*entries) + transform
    return descriptor + struct.pack("<3q", start, start + len(body), start + len(body) + len(voxels)) + body + voxels


def file_of(*grids: tuple) -> bytes:
    data = header() + struct.pack("<I", len(grids))
    for one in grids:
        data += grid(len(data), *one)
    return data


UNIFORM = text("UniformScaleMap") + struct.pack("<15d", *[0.5] * 15)
FRUSTUM = text("NonlinearFrustumMap") + b"?" * 80
BOX = {"min": (-4, 0, 2), "max": (4, 8, 10)}
SOUND = file_of(
    ("surface", "Tree_float_5_4_3_HalfFloat", UNIFORM, entry("class", "string", b"level set")),
    ("density\x1e1", "Tree_float_5_4_3", UNIFORM, entry("class", "string", b"unknown")),
    ("vel", "Tree_vec3s_5_4_3", UNIFORM, entry("odd", "matrix of mine", b"123")),
    ("warped", "Tree_bool_5_4_3", FRUSTUM, entry("gain", "double", struct.pack("<d", 2.5))),
)


def write(folder: Path, data: bytes) -> Path:
    path = folder / "file.vdb"
    path.write_bytes(data)
    return path


def test_grids_are_listed_in_order(tmp_path):
    grids = [(grid.name, grid.grid_class) for grid in inspect(write(tmp_path, SOUND))]
    assert grids == [("surface", "level set"), ("density", ""), ("vel", ""), ("warped", "")]


def test_a_level_set_says_how_large_it_is(tmp_path):
    corners = [entry(f"file_bbox_{end}", "vec3i", struct.pack("<3i", *at)) for end, at in BOX.items()]
    facts = [entry("class", "string", b"level set"), *corners, entry("voxel", "float", struct.pack("<f", 0.25))]
    path = write(tmp_path, file_of(("surface", "Tree_float_5_4_3", UNIFORM, *facts)))
    assert box(path) == ((-1.0, 0.0, 0.5), (1.0, 2.0, 2.5))


def test_grids_without_a_size_are_refused(tmp_path):
    with pytest.raises(BadInput, match=r"no level set 'surface' of known size.*export_vdb"):
        box(write(tmp_path, SOUND))


@pytest.mark.parametrize(
    ("data", "reported"),
    [
        (b"PNG\r\n" * 9, "not an OpenVDB file"),
        (header(213), r"the file has version 213 \(version 222 or later\)"),
        (header(offsets=False), "written as a stream"),
        (header()[:90], "the file ends"),
        (header() + struct.pack("<I", 2**32 - 1), "4294967295 entries are announced"),
        (header()[:57] + struct.pack("<I", 2**31), "2147483648 entries are announced"),
        (header() + struct.pack("<II", 1, 2**32 - 1) + b" " * 99, "the file ends where 4294967295 bytes"),
        (SOUND[:-80], "the next grid should be at byte"),
    ],
)
def test_damaged_files_are_refused(tmp_path, data, reported):
    with pytest.raises(BadInput, match=reported) as refusal:
        inspect(write(tmp_path, data))
    assert "file.vdb, byte" in str(refusal.value)


def test_offsets_that_lead_back_are_refused(tmp_path):
    at = SOUND.index(b"Tree_float_5_4_3_HalfFloat") + 26 + 4
    for place in (0, -1, 2**62):
        data = SOUND[:at] + struct.pack("<q", place) + SOUND[at + 8 :]
        with pytest.raises(BadInput, match="the next grid should be"):
            inspect(write(tmp_path, data))


def test_no_file_and_a_folder_are_refused(tmp_path):
    for path in (tmp_path / "missing.vdb", tmp_path):
        with pytest.raises(BadInput):
            inspect(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300, deadline=None)
@given(st.data())
def test_damage_gives_a_message_or_grids(tmp_path, data):
    damaged = bytearray(SOUND)
    for _ in range(data.draw(st.integers(1, 6))):
        damaged[data.draw(st.integers(0, len(SOUND) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.one_of(st.none(), st.integers(0, len(SOUND))))
    try:
        inspect(write(tmp_path, bytes(damaged[:cut])))
    except BadInput as refusal:
        assert "file.vdb" in str(refusal)


CELL = 0.01


@pytest.fixture
def fog():
    """A box with holes, on both sides of the origin, over several leaves and two nodes of the root."""
    rng = np.random.default_rng(4)
    length = rng.uniform(1.0, 1e5, (20, 9, 30)).astype(np.float32) * (rng.uniform(size=(20, 9, 30)) < 0.3)
    return Density(np.array([-10, 4091, 7], np.int32), CELL, length, np.zeros((*length.shape, 3), np.float32))


@pytest.fixture
def fog_file(fog, tmp_path):
    def write(density=fog, **how):
        vdb.write(tmp_path / "fog.vdb", density_grids(density), 3, **how)
        return tmp_path / "fog.vdb"

    return write


def back(path):
    found = read_here(path, "density")
    return density_of_voxels(found.indices, found.values, found.voxel, found.translation)


def test_a_density_is_read_back_to_the_bit(fog_file, fog):
    found, there = back(fog_file()), np.argwhere(fog.length)
    low, high = there.min(axis=0), there.max(axis=0) + 1
    np.testing.assert_array_equal(found.low, fog.low + low)
    np.testing.assert_array_equal(found.length, fog.length[tuple(map(slice, low, high))])
    assert found.cell == CELL


def test_grid_of_16_bits_is_read_to_its_precision(fog_file, fog):
    thin = dataclasses.replace(fog, length=np.float32(0.1) * fog.length)
    whole, half = back(fog_file(thin)), back(fog_file(thin, half=True))
    np.testing.assert_allclose(half.length, whole.length, rtol=1e-3)
    with pytest.raises(BadInput, match=r"'density' has values up to .* too large for 16 bits"):
        fog_file(fog, half=True)


def test_compressed_grid_is_equal(fog_file, monkeypatch):
    """As OpenVDB zips: a length before every buffer, not positive where its bytes are not packed."""
    plain = back(fog_file())

    def zipped(tree):
        masks = vdb.bits(tree.active)
        for leaf, active in enumerate(tree.active):
            data = tree.values[leaf][active].tobytes()
            packed = zlib.compress(data)
            packed = (
                struct.pack("<q", len(packed)) + packed
                if len(packed) < len(data)
                else struct.pack("<q", -len(data)) + data
            )
            yield masks[leaf].tobytes() + b"\0" + packed

    monkeypatch.setattr(vdb, "ACTIVE_VALUES_ONLY", 3)
    monkeypatch.setattr(vdb, "ALL_BACKGROUND", b"\0" + bytes(8))
    monkeypatch.setattr(vdb, "buffers", zipped)
    assert back(fog_file()).length.tobytes() == plain.length.tobytes()


@pytest.fixture(params=["float", "double", "half"])
def blosc_file(request, openvdb, tmp_path, fog):
    """A grid that OpenVDB has written with Blosc, among it a tile of 8^3 voxels; and values that are in it."""
    grid = openvdb.DoubleGrid() if request.param == "double" else openvdb.FloatGrid()
    grid.name, grid.transform = "density", openvdb.createLinearTransform(voxelSize=CELL)
    values = np.round(fog.length / 1e5, 2).astype(np.float16).astype(np.float32)
    grid.copyFromArray(
        values.astype(np.float64 if request.param == "double" else np.float32), ijk=tuple(fog.low.tolist())
    )
    grid.fill((800, 0, 0), (807, 7, 7), 0.5)
    grid.prune()
    grid.saveFloatAsHalf = request.param == "half"
    openvdb.write(str(tmp_path / "fog.vdb"), [grid])
    return tmp_path / "fog.vdb", {**by_place(np.argwhere(values) + fog.low, values[values != 0.0]), (800, 0, 0): 0.5}


def by_place(indices, values):
    return dict(zip(map(tuple, indices.tolist()), values.tolist(), strict=True))


def test_blosc_of_openvdb_is_read(blosc_file):
    pytest.importorskip("blosc")
    path, expected = blosc_file
    assert b"blosc + active values" in path.read_bytes()
    found = read_here(path, "density")
    assert (len(found.values), found.voxel) == (len(expected) + 511, CELL)
    assert by_place(found.indices, found.values).items() >= expected.items()
    data, rng = path.read_bytes(), np.random.default_rng(7)
    for _ in range(20):
        damaged = bytearray(data)
        damaged[rng.integers(len(data) // 2, len(data))] = rng.integers(256)
        path.write_bytes(damaged)
        with contextlib.suppress(BadInput):
            read_here(path, "density")


def test_openvdb_reads_what_is_not_read_here(blosc_file, openvdb, monkeypatch, tmp_path):
    """Blosc without its library, a mask, a file without a table of grids; points are refused by name."""
    path, expected = blosc_file
    monkeypatch.setitem(sys.modules, "blosc", None)
    found = read_here(path, "density")
    assert (len(found.values), found.voxel) == (len(expected) + 511, CELL)
    assert by_place(found.indices, found.values).items() >= expected.items()
    monkeypatch.setattr(vdb, "find_openvdb", lambda: None)
    with pytest.raises(BadInput, match=r"compressed by Blosc \(pip install 'hairpipe\[vdb\]'"):
        read_here(path, "density")


def test_openvdb_reads_masks_and_streams(openvdb, tmp_path):
    mask, vectors, points = openvdb.BoolGrid(), openvdb.Vec3SGrid(), openvdb.PointDataGrid()
    mask.name, vectors.name, points.name = "mask", "vel", "dust"
    mask.fill((-3, 0, 0), (20, 8, 9), True)
    path = tmp_path / "mask.vdb"
    openvdb.write(str(path), [mask, vectors, points])
    found = read_here(path, "mask")
    assert set(found.values.tolist()) == {1.0} and len(found.values) == 24 * 9 * 10
    assert (found.indices.min(axis=0).tolist(), found.indices.max(axis=0).tolist()) == ([-3, 0, 0], [20, 8, 9])
    with pytest.raises(
        BadInput, match=r"mask\.vdb, grid 'vel': OpenVDB failed: the grid is one of vec3s, not of numbers"
    ):
        read_here(path, "vel")
    with pytest.raises(BadInput, match="the grid 'dust' holds points"):
        read_here(path, "dust")
    stream = bytearray(path.read_bytes())
    stream[20] = 0  # without a table of the places of grids
    path.write_bytes(stream)
    assert len(read_here(path, "mask").values) == 24 * 9 * 10
    with pytest.raises(BadInput, match="the grid is one of ptdataidx32, not of numbers"):
        read_here(path, "dust")


def test_a_density_between_nodes_keeps_its_amount_and_its_middle(fog):
    indices = np.argwhere(fog.length) + fog.low
    values, shift = fog.length[tuple((indices - fog.low).T)], np.array([0.0031, 0.005, -0.0007])
    moved = density_of_voxels(indices, values, CELL, shift)
    assert moved.length.sum(dtype=float) == pytest.approx(values.sum(dtype=float), rel=1e-5)
    nodes = CELL * (np.stack(np.indices(moved.length.shape), axis=3) + moved.low)
    middle = np.einsum("ijk,ijkc->c", moved.length.astype(float), nodes) / moved.length.sum(dtype=float)
    expected = (values.astype(float) @ (CELL * indices + shift)) / values.sum(dtype=float)
    np.testing.assert_allclose(middle, expected, atol=1e-6)


def test_other_grids_are_refused(fog_file, monkeypatch):
    path = fog_file()
    monkeypatch.setattr(vdb, "find_openvdb", lambda: None)
    with pytest.raises(BadInput, match=r"no grid 'smoke'.*density, hair_vel"):
        read_here(path, "smoke")
    with pytest.raises(BadInput, match="the grid is a Tree_vec3s"):
        read_here(path, "hair_vel")
    data = path.read_bytes()
    path.write_bytes(data.replace(b"UniformScaleMap", b"NonlinearFrstum"))
    with pytest.raises(BadInput, match="is placed by a NonlinearFrstum"):
        read_here(path, "density")


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
