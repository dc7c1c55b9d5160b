"""Files of USC-HairSalon (.data) and of reconstructions (.bin), written byte by byte."""

import struct

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.polylines import read_records

COUNTS = (4, 2, 7, 3, 5)


@pytest.mark.parametrize(("suffix", "width"), [(".data", 3), (".bin", 7)])
@pytest.mark.filterwarnings("ignore:.*directions and labels")
def test_strands_follow_one_another(tmp_path, strands, record_bytes, suffix, width):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(record_bytes(width))
    found = read_records(path, 0.001)
    assert np.allclose(found.points, 0.001 * np.concatenate(strands), rtol=1e-12)
    assert np.diff(found.offsets).tolist() == list(COUNTS) and found.widths is None


def test_directions_and_labels_are_named(tmp_path, record_bytes):
    path = tmp_path / "a.bin"
    path.write_bytes(record_bytes(7))
    with pytest.warns(UserWarning, match="directions and labels are not read"):
        read_records(path)


def test_strands_without_points_are_left_out(tmp_path, record_bytes):
    path = tmp_path / "a.data"
    path.write_bytes(struct.pack("<i", 7) + struct.pack("<i", 0) + record_bytes(3)[4:] + struct.pack("<i", 0))
    with pytest.warns(UserWarning, match="2 strands have no points and are left out"):
        assert np.diff(read_records(path).offsets).tolist() == list(COUNTS)


@pytest.mark.parametrize(
    ("byte", "value", "message"),
    [
        (0, -1, r"byte 0: -1 strands \(1 to \d+, for a file of 276 bytes\)"),
        (0, 2**31 - 1, r"byte 0: 2147483647 strands"),
        (0, 6, r"byte 276: strand 5 of 6 is missing \(a whole file\)"),
        (0, 4, r"byte 212: 64 bytes follow the last strand"),
        (4, 2**31 - 1, r"byte 4: strand 0 has 2147483647 points \(0 to 22: the file has no more\)"),
        (4, -3, r"byte 4: strand 0 has -3 points"),
    ],
)
def test_bad_file_is_reported_with_place_and_fault(tmp_path, record_bytes, byte, value, message):
    data = record_bytes(3)
    path = tmp_path / "bad.data"
    path.write_bytes(data[:byte] + struct.pack("<i", value) + data[byte + 4 :])
    with pytest.raises(BadInput, match=message):
        read_records(path)
