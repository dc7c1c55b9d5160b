"""Lines of OBJ and PLY files as strands; both formats written from their description."""

import struct

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.polylines import chains, read_obj_strands, read_ply_strands

COUNTS = (4, 2, 7, 3, 5)

STARTS = np.cumsum((0, *COUNTS[:-1]))


def obj_text(strands, edges: bool = False) -> str:
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in np.concatenate(strands)]
    for name, start, count in zip("aabbc", STARTS, COUNTS, strict=True):
        lines.append(f"o {name}")
        indices = range(start + 1, start + count + 1)
        lines += [f"l {i} {i + 1}" for i in indices[:-1]] if edges else ["l " + " ".join(map(str, indices))]
    return "\n".join(lines)


@pytest.mark.parametrize("edges", [False, True], ids=["lines", "edges"])
def test_obj_lines_are_strands_and_objects_are_groups(tmp_path, strands, edges):
    path = tmp_path / "a.obj"
    path.write_text(obj_text(strands, edges))
    found = read_obj_strands(path)
    assert np.allclose(found.points, np.concatenate(strands), rtol=1e-8)
    assert np.diff(found.offsets).tolist() == list(COUNTS)
    assert found.group_names == ("a", "b", "c") and found.groups.tolist() == [0, 0, 1, 1, 2]


def ply_bytes(strands, form: str, kind: str) -> bytes:
    """Vertices with thickness and 8-bit colours; strands by edges or by numbers of segments; and a face."""
    points = np.concatenate(strands)
    header = f"ply\nformat {form} 1.0\ncomment ours\nelement vertex {len(points)}\n"
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
    code = "ii" if kind == "edge" else "H"
    if form == "ascii":
        body = "".join(f"{x:.9g} {y:.9g} {z:.9g} 0.25 {k} 0 255\n" for k, (x, y, z) in enumerate(points))
        body += "3 0 1 2\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows)
        return (header + body).encode()
    order = "<" if "little" in form else ">"
    body = b"".join(struct.pack(f"{order}4f3B", *p, 0.25, k, 0, 255) for k, p in enumerate(points))
    body += struct.pack(f"{order}B3i", 3, 0, 1, 2)
    return header.encode() + body + b"".join(struct.pack(order + code, *row) for row in rows)


@pytest.mark.parametrize("kind", ["edge", "strand"])
@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_ply_strands_have_widths_and_colours(tmp_path, strands, form, kind):
    path = tmp_path / "a.ply"
    path.write_bytes(ply_bytes(strands, form, kind))
    found = read_ply_strands(path, 0.1)
    assert np.allclose(found.points, 0.1 * np.concatenate(strands), rtol=1e-8)
    assert np.diff(found.offsets).tolist() == list(COUNTS)
    assert np.allclose(found.widths, 0.025)
    places = np.arange(sum(COUNTS)) / 255
    assert np.allclose(found.colours, np.stack([places, 0 * places, 0 * places + 1], axis=1))


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


PLY = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n{}end_header\n{}"
BAD = {
    "a.obj": [
        ("v 0 0 0\nv 0 1 0\nf 1 2 1\n", "there are no lines"),
        ("v 0 0 0\nl 1\n", "line 2: a line has 1 vertices"),
        ("v 0 0 0\nl 1 2\n", "line 2: index 2 does not exist"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nl 1 2\nl 1 3\nl 1 4\n", "3 edges meet at vertex 0"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3 1\n", "the line through vertex 0 is closed"),
    ],
    "a.ply": [
        ("plx", "byte 0: the file does not begin with 'ply'"),
        ("ply\nformat ascii 1.0\n", "the header does not end"),
        ("ply\nformat odd 1.0\nend_header\n", "line 2: 'format odd 1.0' is not a statement"),
        (PLY.format("", "0 0 0 1 0 0"), "no strands among the elements vertex"),
        (PLY.format("", "0 0 0 1 0"), "2 rows of vertex need 6 values or bytes more, the file has 5"),
        (PLY.format("", "0 0 0 1 x 0"), "'x' is not a number"),
        (PLY.format("element strand 1\nproperty int nsegs\n", "0 0 0 1 0 0 4"), "nsegs of 1 strands give 5 points"),
        (PLY.format("element strand 1\nproperty float nsegs\n", "0 0 0 1 0 0 nan"), "nsegs of row 0 is nan"),
        (PLY.format("element edge 1\nproperty int vertex1\nproperty int vertex2\n", "0 0 0 1 0 0 0 9"), "vertex 9"),
        (PLY.format(f"element edge {10**15}\nproperty int vertex1\n", "0 0 0 1 0 0 0"), "rows of edge need"),
    ],
}


@pytest.mark.parametrize(("name", "text", "message"), [(name, *row) for name, rows in BAD.items() for row in rows])
def test_bad_file_is_reported_with_place_and_fault(tmp_path, name, text, message):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(BadInput, match=message) as caught:
        (read_obj_strands if name.endswith("obj") else read_ply_strands)(path)
    assert name in str(caught.value)
