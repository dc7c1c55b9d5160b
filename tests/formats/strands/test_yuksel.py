"""HAIR files, written byte by byte from the description of the format."""

import struct

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.yuksel import read_hair

COUNTS = (4, 2, 7, 3, 5)


def test_all_arrays_are_read(tmp_path, strands, hair_bytes):
    path = tmp_path / "a.hair"
    path.write_bytes(hair_bytes())
    found = read_hair(path)
    assert np.array_equal(found.points, np.concatenate(strands).astype(float))
    assert np.diff(found.offsets).tolist() == list(COUNTS) and found.ids.tolist() == [0, 1, 2, 3, 4]
    places = np.arange(sum(COUNTS))
    assert np.allclose(found.widths, 0.001 * places) and np.allclose(found.colours, places[:, None] / 32)
    inches = read_hair(path, 0.0254, "z")
    assert np.allclose(inches.points, 0.0254 * found.points[:, [0, 2, 1]] * (1, 1, -1))
    assert np.allclose(inches.widths, 0.0254 * found.widths)


def test_without_arrays_the_header_holds(tmp_path, strands, hair_bytes):
    path = tmp_path / "a.hair"
    equal = np.concatenate([s[:2] for s in strands for _ in range(2)])
    path.write_bytes(hair_bytes(arrays=2, count=5, total=20)[:128] + equal.astype("<f4").tobytes())
    found = read_hair(path)
    assert np.diff(found.offsets).tolist() == [4] * 5, "segments of the header"
    assert (found.widths == 0.5).all() and np.allclose(found.colours, (0.25, 0.5, 0.75))


def test_transparency_is_named(tmp_path, hair_bytes):
    path = tmp_path / "a.hair"
    path.write_bytes(hair_bytes(arrays=31))
    with pytest.warns(UserWarning, match="transparency is not read"):
        assert len(read_hair(path).colours) == sum(COUNTS)


def changed(data: bytes, byte: int, form: str, value: object) -> bytes:
    return data[:byte] + struct.pack(form, value) + data[byte + struct.calcsize(form) :]


@pytest.mark.parametrize(
    ("byte", "form", "value", "message"),
    [
        (0, "4s", b"BALD", r"byte 0: the file does not begin with a header of HAIR"),
        (4, "<I", 0, r"byte 4: no strands"),
        (
            4,
            "<I",
            2**32 - 1,
            r"byte 4: 4294967295 strands of 21 points need \d+ bytes, the file has \d+ \(a whole file\)",
        ),
        (8, "<I", 2**32 - 1, r"byte 4: 5 strands of 4294967295 points need"),
        (8, "<I", 20, r"byte 128: segments give 21 points \(the number of points, 20\)"),
        (12, "<I", 1, r"byte 12: arrays are 0x1 "),
        (12, "<I", 64 + 3, r"byte 12: arrays are 0x43 "),
    ],
)
def test_bad_file_is_reported_with_place_and_fault(tmp_path, hair_bytes, byte, form, value, message):
    path = tmp_path / "bad.hair"
    path.write_bytes(changed(hair_bytes(), byte, form, value))
    with pytest.raises(BadInput, match=message):
        read_hair(path)
