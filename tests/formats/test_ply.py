"""PLY files: numbers of any length, lists of any lengths, and time in proportion to the file."""

import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.ply import Lists, read_ply

HEAD = """ply
format {} 1.0
element face {}
property uchar flag
property list uchar int a
property list ushort short b
end_header
"""
ROWS = [(1, [5, -6, 7], [1]), (2, [], []), (3, [8], [-2, 3])]


def text_of(rows: list) -> bytes:
    lines = (" ".join(map(str, [flag, len(a), *a, len(b), *b])) for flag, a, b in rows)
    return HEAD.format("ascii", len(rows)).encode() + "\n".join(lines).encode()


def binary_of(rows: list, order: str, name: str) -> bytes:
    items = (
        np.array(values, order + kind).tobytes()
        for flag, a, b in rows
        for values, kind in ((flag, "u1"), (len(a), "u1"), (a, "i4"), (len(b), "u2"), (b, "i2"))
    )
    return HEAD.format(name, len(rows)).encode() + b"".join(items)


@pytest.mark.parametrize("rows", [ROWS, ROWS[:1] * 5, ROWS[1:2] * 3, []])
def test_lists_of_any_lengths_are_read_in_all_formats(tmp_path: Path, rows: list):
    contents = (text_of(rows), binary_of(rows, "<", "binary_little_endian"), binary_of(rows, ">", "binary_big_endian"))
    for content in contents:
        (tmp_path / "a.ply").write_bytes(content)
        face = read_ply(tmp_path / "a.ply")["face"]
        assert np.asarray(face["flag"]).tolist() == [flag for flag, _, _ in rows]
        for name, place in (("a", 1), ("b", 2)):
            found = face[name]
            assert isinstance(found, Lists)
            assert found.counts.tolist() == [len(row[place]) for row in rows]
            assert found.values.tolist() == [value for row in rows for value in row[place]]


def test_numbers_of_any_length_are_read(tmp_path: Path):
    words = ["1." + 40 * "0" + "e-01", "0" * 60 + "7.5", "3." + 50 * "3"]
    head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nend_header\n"
    (tmp_path / "a.ply").write_text(head + "\n".join(words))
    assert np.asarray(read_ply(tmp_path / "a.ply")["vertex"]["x"]).tolist() == [float(word) for word in words]


@pytest.mark.parametrize("count", [999_999_999_999, 10**18 - 1])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_counts_are_compared_with_the_file_before_memory_is_taken(tmp_path: Path, count: int, form: str):
    (tmp_path / "a.ply").write_bytes(HEAD.format(form, count).encode() + b"0 " * 100)
    tracemalloc.start()
    with pytest.raises(BadInput, match=r"rows of face need \d+ values or bytes more"):
        read_ply(tmp_path / "a.ply")
    assert tracemalloc.get_traced_memory()[1] < 1 << 20
    tracemalloc.stop()


def test_a_list_longer_than_the_file_is_refused(tmp_path: Path):
    (tmp_path / "a.ply").write_bytes(text_of([(1, [2], [3])]).replace(b"1 1 2 1 3", b"1 99999999 2 1 3"))
    with pytest.raises(BadInput, match=r"a list of face has 1e\+08 values"):
        read_ply(tmp_path / "a.ply")


@pytest.mark.parametrize("row", ["0 0 0\n", "1 1 7 0\n2 0 1 4\n"])
def test_time_grows_with_the_file(tmp_path: Path, row: str):
    """A megabyte of lists, empty ones and alternating ones."""
    count = (1 << 20) // len(row)
    (tmp_path / "a.ply").write_bytes(HEAD.format("ascii", count * row.count("\n")).encode() + count * row.encode())
    begun = time.process_time()
    read_ply(tmp_path / "a.ply")
    assert time.process_time() - begun < 8.0
