"""TressFX files, packed by hand and fuzzed."""

import struct
from pathlib import Path

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.tfx import read_tfx

POINTS = [[(0, 1, 2), (3, 4, 5), (6, 7, 8)], [(-1, 0.5, 0), (-1, 0.25, 0), (-1, 0.125, 4)]]


def pack(points=POINTS, *, version=4.0, strands=None, count=None, start=160, tail=b""):
    """A file as the layout says: header of 160 bytes, then x, y, z and inverse mass of every point."""
    strands = len(points) if strands is None else strands
    count = len(points[0]) if count is None else count
    header = struct.pack("<f7I", version, strands, count, start, 0, 0, 0, 0).ljust(160, b"\0")
    body = b"".join(struct.pack("<4f", *p, float(k > 0)) for strand in points for k, p in enumerate(strand))
    return header + b"\0" * (start - 160) + body + tail


def pack_3(points=POINTS, *, held=0, start=296):
    """The same in version 3: a header of 296 bytes, then x, y, z of every point."""
    header = struct.pack("<f4I", 3.0, len(points), len(points[0]), 4, held).ljust(144, b"\0")
    header = (header + struct.pack("<I", start)).ljust(start, b"\0")
    return header + b"".join(struct.pack("<3f", *p) for strand in points for p in strand)


def write(folder: Path, data: bytes) -> Path:
    path = folder / "hair.tfx"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("more", [{}, {"tail": b"uv and more"}, {"start": 176}])
def test_positions_are_read_strand_after_strand(tmp_path, more):
    found = read_tfx(write(tmp_path, pack(**more)))
    points, offsets = found.points, found.offsets
    assert np.array_equal(points, np.array(POINTS, float).reshape(-1, 3)) and points.dtype == np.float64
    assert np.array_equal(offsets, [0, 3, 6]) and offsets.dtype == np.int32
    assert points.flags.c_contiguous


def test_centimetres_with_z_up_become_metres_with_y_up(tmp_path):
    found = read_tfx(write(tmp_path, pack()), 0.01, "z")
    assert np.allclose(found.points[:2], [[0.0, 0.02, -0.01], [0.03, 0.05, -0.04]])


@pytest.mark.parametrize("start", [296, 304])
def test_version_3_is_read_as_version_4_is(tmp_path, start):
    new, old = read_tfx(write(tmp_path, pack())), read_tfx(write(tmp_path, pack_3(start=start)))
    assert np.array_equal(new.points, old.points) and np.array_equal(new.offsets, old.offsets)
    assert not new.held.any() and not old.held.any()
    assert read_tfx(write(tmp_path, pack_3(held=1))).held.all()


def test_a_tip_without_inverse_mass_is_held_as_the_root_is(tmp_path):
    data = bytearray(pack())
    struct.pack_into("<f", data, 160 + 2 * 16 + 12, 0.0)
    assert read_tfx(write(tmp_path, bytes(data))).held.tolist() == [True, False]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", r"hair.tfx: the file is empty"),
        (pack()[:159], "the file has 159 bytes"),
        (pack()[:-1], r"byte 4: 2 strands of 3 points need 256 bytes, the file has 255"),
        (pack(strands=2**32 - 1), "4294967295 strands of 3 points need"),
        (pack(count=2**32 - 1), "2 strands of 4294967295 points need"),
        (pack(strands=0), "byte 4: no strands"),
        (pack(count=1), "byte 8: 1 points a strand"),
        (pack(version=2.0), r"byte 0: version 2 \(binary TressFX of version 3.0 or 4.0\)"),
        (pack(version=float("nan")), "version nan"),
        (pack()[:12] + b"\0\0\0\0" + pack()[16:], "byte 12: positions begin at byte 0"),
        (pack_3()[:295], r"the file has 295 bytes \(a header of 296 bytes\)"),
        (pack_3()[:-1], "2 strands of 3 points need 368 bytes, the file has 367"),
        (pack_3(start=296)[:144] + bytes(4) + pack_3()[148:], "byte 144: positions begin at byte 0"),
        (b"version 2.0\nscale 1.0\nrotation 0 0 0\n", "binary TressFX of version 3.0 or 4.0"),
        (b"v 0 0 0\r\n" * 40, "version"),
    ],
)
def test_bad_file_is_reported_with_place_and_fault(tmp_path, data, message):
    with pytest.raises(BadInput, match=message):
        read_tfx(write(tmp_path, data))


def test_a_position_that_is_not_finite_is_left_to_the_import(tmp_path):
    found = read_tfx(write(tmp_path, pack([[(0, 0, 0), (0, 1, 0)], [(0, 0, 0), (0, float("inf"), 0)]])))
    assert np.isfinite(found.points).all(axis=1).tolist() == [True, True, True, False]


def test_arrays_that_are_not_read_are_named(tmp_path):
    data = pack()
    with pytest.warns(UserWarning, match="hair.tfx: arrays that are not read: thickness$"):
        read_tfx(write(tmp_path, data[:24] + struct.pack("<I", 160) + data[28:]))


def test_unreadable_file_is_reported(tmp_path):
    with pytest.raises(BadInput, match="cannot be read: No such file"):
        read_tfx(tmp_path / "none.tfx")
    with pytest.raises(BadInput, match="cannot be read: it is a directory"):
        read_tfx(tmp_path)


def test_sintels_hair_is_what_was_measured(shared):
    found = read_tfx(shared / "sintel" / "SintelHairOriginal-sintel_hair.16points.tfx")
    points, offsets = found.points, found.offsets
    assert not found.held.any() and len(offsets) - 1 == 11_400 and (np.diff(offsets) == 16).all()
    roots = points[offsets[:-1]]
    assert np.allclose(roots.min(axis=0), (-0.082, 1.476, -0.102), atol=1e-3)
    assert np.allclose(roots.max(axis=0), (0.082, 1.655, 0.098), atol=1e-3)
    lengths = np.linalg.norm(np.diff(points.reshape(-1, 16, 3), axis=1), axis=2).sum(axis=1)
    assert np.allclose(np.quantile(lengths, (0, 0.5, 1)), (0.025, 0.102, 0.248), atol=6e-4)
