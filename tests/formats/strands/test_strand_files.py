"""Strands of HAIR, .data, .bin, OBJ and PLY files, each written from the description of the format."""

import struct

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.polylines import chains, read_obj_strands, read_ply_strands, read_records
from hairpipe.formats.yuksel import read_hair

COUNTS = (4, 2, 7, 3, 5)
STARTS = np.cumsum((0, *COUNTS[:-1]))
PLACES = np.arange(sum(COUNTS))
RANDOM = np.random.default_rng(3)
STRANDS = [np.float32(np.cumsum(RANDOM.uniform(0.01, 0.1, (count, 3)), axis=0)) for count in COUNTS]
POINTS = np.concatenate(STRANDS)


def hair_bytes(arrays: int = 23, count: int = len(COUNTS), total: int = len(POINTS)) -> bytes:
    """A HAIR file with all arrays: thickness 0.001 k, colours k / 32 of point k."""
    header = b"HAIR" + struct.pack("<4I5f", count, total, arrays, 3, 0.5, 0.0, 0.25, 0.5, 0.75)
    parts = {
        1: np.array(COUNTS, "<u2") - np.uint16(1),
        2: POINTS,
        4: np.float32(0.001 * PLACES),
        8: np.float32(0.0 * PLACES),
        16: np.float32(np.repeat(PLACES / 32, 3)),
    }
    return header + bytes(88) + b"".join(part.tobytes() for bit, part in parts.items() if arrays & bit)


def record_bytes(width: int = 3) -> bytes:
    rows = [np.hstack([s, np.full((len(s), width - 3), 9.0)]).astype("<f4") for s in STRANDS]
    return struct.pack("<i", len(rows)) + b"".join(struct.pack("<i", len(row)) + row.tobytes() for row in rows)


def obj_bytes(edges: bool) -> bytes:
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in POINTS]
    for name, start, count in zip("aabbc", STARTS, COUNTS, strict=True):
        indices = range(start + 1, start + count + 1)
        lines.append(f"o {name}")
        lines += [f"l {i} {i + 1}" for i in indices[:-1]] if edges else ["l " + " ".join(map(str, indices))]
    return "\n".join(lines).encode()


def ply_bytes(form: str, kind: str) -> bytes:
    """Vertices with thickness and 8-bit colours; strands by edges or by numbers of segments; and a face."""
    header = f"ply\nformat {form} 1.0\ncomment ours\nelement vertex {len(POINTS)}\n"
    header += "".join(f"property float {name}\n" for name in ("x", "y", "z", "thickness"))
    header += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    header += "element face 1\nproperty list uchar int vertex_indices\n"
    if kind == "edge":
        rows = [(s + i, s + i + 1) for s, n in zip(STARTS, COUNTS, strict=True) for i in range(n - 1)]
        header += f"element edge {len(rows)}\nproperty int vertex1\nproperty int vertex2\n"
    else:
        rows = [(n - 1,) for n in COUNTS]
        header += f"element strand {len(rows)}\nproperty ushort nsegs\n"
    header += "end_header\n"
    if form == "ascii":
        body = "".join(f"{x:.9g} {y:.9g} {z:.9g} 0.25 {k} 0 255\n" for k, (x, y, z) in enumerate(POINTS))
        return (header + body + "3 0 1 2\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows)).encode()
    order, code = "<" if "little" in form else ">", "ii" if kind == "edge" else "H"
    body = b"".join(struct.pack(f"{order}4f3B", *p, 0.25, k, 0, 255) for k, p in enumerate(POINTS))
    body += struct.pack(f"{order}B3i", 3, 0, 1, 2)
    return header.encode() + body + b"".join(struct.pack(order + code, *row) for row in rows)


READERS = {
    "hair": read_hair,
    "data": read_records,
    "bin": read_records,
    "obj": read_obj_strands,
    "ply": read_ply_strands,
}


@pytest.fixture
def read(tmp_path):
    """Write a file of a suffix and read it."""

    def from_bytes(suffix: str, data: bytes, *settings):
        (tmp_path / f"a.{suffix}").write_bytes(data)
        return READERS[suffix](tmp_path / f"a.{suffix}", *settings)

    return from_bytes


FORMS = ("ascii", "binary_little_endian", "binary_big_endian")
FILES = {
    "hair": ("hair", hair_bytes()),
    "data": ("data", record_bytes()),
    "bin": ("bin", record_bytes(7)),
    "obj of lines": ("obj", obj_bytes(False)),
    "obj of edges": ("obj", obj_bytes(True)),
    **{f"{form} ply of {kind}": ("ply", ply_bytes(form, kind)) for form in FORMS for kind in ("edge", "strand")},
}


@pytest.mark.filterwarnings("ignore:.*directions and labels")
@pytest.mark.parametrize(("suffix", "data"), FILES.values(), ids=FILES)
def test_points_are_those_of_the_strands_in_the_unit_given(read, suffix, data):
    found = read(suffix, data, 0.1)
    np.testing.assert_allclose(found.points, 0.1 * POINTS.astype(float), rtol=1e-8)
    assert np.diff(found.offsets).tolist() == list(COUNTS) and found.ids.tolist() == [0, 1, 2, 3, 4]
    if suffix == "ply":
        np.testing.assert_allclose(found.widths, 0.025)
        np.testing.assert_allclose(found.colours, np.stack([PLACES / 255, 0 * PLACES, 0 * PLACES + 1], axis=1))
    elif suffix == "hair":
        np.testing.assert_allclose(found.widths, 1e-4 * PLACES, rtol=1e-6)
        np.testing.assert_allclose(found.colours, np.tile(PLACES[:, None] / 32, 3))
    else:
        assert found.widths is None
    if suffix == "obj":
        assert found.group_names == ("a", "b", "c") and found.groups.tolist() == [0, 0, 1, 1, 2]


def test_an_axis_that_points_up_is_turned(read):
    inches = read("hair", hair_bytes(), 0.0254, "z")
    np.testing.assert_allclose(inches.points, 0.0254 * POINTS[:, [0, 2, 1]].astype(float) * (1, 1, -1))


def test_without_arrays_the_header_of_hair_holds(read):
    equal = np.concatenate([s[:2] for s in STRANDS for _ in range(2)])
    found = read("hair", hair_bytes(arrays=2, total=20)[:128] + equal.tobytes())
    assert np.diff(found.offsets).tolist() == [4] * 5, "segments of the header"
    assert (found.widths == 0.5).all() and np.allclose(found.colours, (0.25, 0.5, 0.75))


EMPTY = struct.pack("<i", 7) + struct.pack("<i", 0) + record_bytes()[4:] + struct.pack("<i", 0)


@pytest.mark.parametrize(
    ("suffix", "data", "message"),
    [
        ("hair", hair_bytes(arrays=31), "transparency is not read"),
        ("bin", record_bytes(7), "directions and labels are not read"),
        ("data", EMPTY, "2 strands have no points and are left out"),
    ],
)
def test_arrays_that_are_not_read_are_named(read, suffix, data, message):
    with pytest.warns(UserWarning, match=message):
        assert np.diff(read(suffix, data).offsets).tolist() == list(COUNTS)


def test_chains_are_those_of_a_walk_along_shuffled_edges():
    generator = np.random.default_rng(1)
    names = generator.permutation(sum(COUNTS))
    lines = [names[s : s + n] for s, n in zip(STARTS, COUNTS, strict=True)]
    edges = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    edges = np.where(generator.random((len(edges), 1)) < 0.5, edges, edges[:, ::-1])[generator.permutation(len(edges))]
    order, counts = chains(edges, len(names), "x")
    found = [tuple(part) for part in np.split(order, np.cumsum(counts)[:-1])]
    forward = [line if line[0] < line[-1] else line[::-1] for line in lines]
    assert sorted(found) == sorted(map(tuple, forward))
    assert [part[0] for part in found] == sorted(part[0] for part in found)


def changed(data: bytes, byte: int, form: str, value: object) -> bytes:
    return data[:byte] + struct.pack(form, value) + data[byte + struct.calcsize(form) :]


def ply(elements: str, body: str) -> bytes:
    head = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
    return f"{head}{elements}end_header\n{body}".encode()


HAIR, DATA, BIG = hair_bytes(), record_bytes(), 2**32 - 1
NSEGS, VERTICES = "element strand 1\nproperty {} nsegs\n", "property int vertex1\nproperty int vertex2\n"
BAD: list[tuple[str, bytes, str]] = [
    ("hair", changed(HAIR, 0, "4s", b"BALD"), r"byte 0: the file does not begin with a header of HAIR"),
    ("hair", changed(HAIR, 4, "<I", 0), r"byte 4: no strands"),
    ("hair", changed(HAIR, 4, "<I", BIG), r"byte 4: \d+ strands of 21 points need \d+ bytes, .* \d+ \(a whole file\)"),
    ("hair", changed(HAIR, 8, "<I", BIG), r"byte 4: 5 strands of 4294967295 points need"),
    ("hair", changed(HAIR, 8, "<I", 20), r"byte 128: segments give 21 points \(the number of points, 20\)"),
    ("hair", changed(HAIR, 12, "<I", 1), r"byte 12: arrays are 0x1 "),
    ("hair", changed(HAIR, 12, "<I", 64 + 3), r"byte 12: arrays are 0x43 "),
    ("data", changed(DATA, 0, "<i", -1), r"byte 0: -1 strands \(1 to \d+, for a file of 276 bytes\)"),
    ("data", changed(DATA, 0, "<i", 2**31 - 1), r"byte 0: 2147483647 strands"),
    ("data", changed(DATA, 0, "<i", 6), r"byte 276: strand 5 of 6 is missing \(a whole file\)"),
    ("data", changed(DATA, 0, "<i", 4), r"byte 212: 64 bytes follow the last strand"),
    ("data", changed(DATA, 4, "<i", 2**31 - 1), r"byte 4: strand 0 has 2147483647 points \(0 to 22: the file has no"),
    ("data", changed(DATA, 4, "<i", -3), r"byte 4: strand 0 has -3 points"),
    ("obj", b"v 0 0 0\nv 0 1 0\nf 1 2 1\n", "there are no lines"),
    ("obj", b"v 0 0 0\nl 1\n", "line 2: a line has 1 vertices"),
    ("obj", b"v 0 0 0\nl 1 2\n", "line 2: index 2 does not exist"),
    ("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nl 1 2\nl 1 3\nl 1 4\n", r"3 edges meet at vertex 0 \(at most 2"),
    ("obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3 1\n", "the line through vertex 0 is closed"),
    ("ply", b"plx", "byte 0: the file does not begin with 'ply'"),
    ("ply", b"ply\nformat ascii 1.0\n", "the header does not end"),
    ("ply", b"ply\nformat odd 1.0\nend_header\n", "line 2: 'format odd 1.0' is not a statement"),
    ("ply", ply("", "0 0 0 1 0 0"), "no strands among the elements vertex"),
    ("ply", ply("", "0 0 0 1 0"), "2 rows of vertex need 6 values or bytes more, the file has 5"),
    ("ply", ply("", "0 0 0 1 x 0"), "'x' is not a number"),
    ("ply", ply(NSEGS.format("int"), "0 0 0 1 0 0 4"), "nsegs of 1 strands give 5 points"),
    ("ply", ply(NSEGS.format("float"), "0 0 0 1 0 0 nan"), "nsegs of row 0 is nan"),
    ("ply", ply(f"element edge 1\n{VERTICES}", "0 0 0 1 0 0 0 9"), "vertex 9"),
    ("ply", ply(f"element edge {10**15}\n{VERTICES}", "0 0 0 1 0 0 0"), "rows of edge need"),
]


@pytest.mark.parametrize(("suffix", "data", "message"), BAD, ids=[message for *_, message in BAD])
def test_bad_file_is_reported_with_place_and_fault(read, suffix, data, message):
    with pytest.raises(BadInput, match=message) as caught:
        read(suffix, data)
    assert f"a.{suffix}" in str(caught.value)
