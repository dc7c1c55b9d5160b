"""Voxels of OpenVDB files: what was written comes back, however it is stored, and damage is told."""

import contextlib
import dataclasses
import struct
import sys
import zlib

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats import vdb
from hairpipe.formats.vdb import density_grids, read_here
from hairpipe.values import Density
from hairpipe.volume.density import density_of_voxels

CELL = 0.01


@pytest.fixture
def fog():
    """A box with holes, on both sides of the origin, over several leaves and two nodes of the root."""
    rng = np.random.default_rng(4)
    length = rng.uniform(1.0, 1e5, (20, 9, 30)).astype(np.float32) * (rng.uniform(size=(20, 9, 30)) < 0.3)
    return Density(np.array([-10, 4091, 7], np.int32), CELL, length, np.zeros((*length.shape, 3), np.float32))


@pytest.fixture
def written(fog, tmp_path):
    def write(density=fog, **how):
        vdb.write(tmp_path / "fog.vdb", density_grids(density), 3, **how)
        return tmp_path / "fog.vdb"

    return write


def back(path):
    found = read_here(path, "density")
    return density_of_voxels(found.indices, found.values, found.voxel, found.translation)


def test_a_density_is_read_back_to_the_bit(written, fog):
    found, there = back(written()), np.argwhere(fog.length)
    low, high = there.min(axis=0), there.max(axis=0) + 1
    np.testing.assert_array_equal(found.low, fog.low + low)
    np.testing.assert_array_equal(found.length, fog.length[tuple(map(slice, low, high))])
    assert found.cell == CELL


def test_grid_of_16_bits_is_read_to_its_precision(written, fog):
    thin = dataclasses.replace(fog, length=np.float32(0.1) * fog.length)
    whole, half = back(written(thin)), back(written(thin, half=True))
    np.testing.assert_allclose(half.length, whole.length, rtol=1e-3)
    with pytest.raises(BadInput, match=r"'density' has values up to .* too large for 16 bits"):
        written(fog, half=True)


def test_compressed_grid_is_equal(written, monkeypatch):
    """As OpenVDB zips: a length before every buffer, not positive where its bytes are not packed."""
    plain = back(written())

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
    assert back(written()).length.tobytes() == plain.length.tobytes()


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


def test_other_grids_are_refused(written, monkeypatch):
    path = written()
    monkeypatch.setattr(vdb, "find_openvdb", lambda: None)
    with pytest.raises(BadInput, match=r"no grid 'smoke'.*density, hair_vel"):
        read_here(path, "smoke")
    with pytest.raises(BadInput, match="the grid is a Tree_vec3s"):
        read_here(path, "hair_vel")
    data = path.read_bytes()
    path.write_bytes(data.replace(b"UniformScaleMap", b"NonlinearFrstum"))
    with pytest.raises(BadInput, match="is placed by a NonlinearFrstum"):
        read_here(path, "density")
