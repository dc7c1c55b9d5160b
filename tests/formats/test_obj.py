import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.obj import read_polygons

SQUARE = """# a square and a triangle
o thing
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0 1.0
v 0 0 1 0.5 0.5 0.5
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
g quad left
f 1/1/1 2/2/1 3/3/1 4/4/1
g side
f 1/1 2/2 5/3
"""


def read_text_as_obj(folder, text: str, group: str | None = None):
    path = folder / "mesh.obj"
    path.write_bytes(text.encode())
    return read_polygons(path, group).mesh


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t,
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.rstrip("\n"),
        lambda t: t.replace("f 1/1/1 2/2/1", "f 1/1/1 \\\n  2/2/1"),
        lambda t: t.replace("f 1/1 2/2 5/3", "f -5/-4 -4/-3 -1/-2  # backwards"),
        lambda t: t.replace("v 1 0 0", "  v\t1 0e5 .0"),
        lambda t: "mtllib a.mtl\nusemtl b\ns off\n" + t,
    ],
)
def test_all_the_ways_to_write_one_mesh(tmp_path, change):
    mesh = read_text_as_obj(tmp_path, change(SQUARE))
    np.testing.assert_array_equal(mesh.points, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]])
    np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 4]])
    np.testing.assert_array_equal(mesh.uv[1], [[0, 0], [1, 1], [0, 1]])
    assert mesh.triangles.dtype == np.int32 and mesh.uv.dtype == np.float32


@pytest.mark.parametrize(("group", "count"), [(None, 3), ("quad", 2), ("left", 2), ("side", 1), ("thing", 3)])
def test_a_group_keeps_its_faces_and_all_vertices(tmp_path, group, count):
    mesh = read_text_as_obj(tmp_path, SQUARE, group)
    assert len(mesh.triangles) == count and len(mesh.points) == 5


@pytest.mark.parametrize("corner", ["{0}", "{0}//1"])
def test_texture_coordinates_that_are_missing_somewhere_are_omitted(tmp_path, corner):
    text = SQUARE.replace("f 1/1 2/2 5/3", "f " + " ".join(corner.format(i) for i in (1, 2, 5)))
    with pytest.warns(UserWarning, match="1 of 2 faces have no texture coordinates: those of the others are not used"):
        assert read_text_as_obj(tmp_path, text).uv is None
    assert read_text_as_obj(tmp_path, text, "quad").uv is not None


def test_statements_that_are_not_read_are_named(tmp_path):
    with pytest.warns(UserWarning, match="statements that are not read: 1 cstype, 2 l$"):
        read_text_as_obj(tmp_path, SQUARE + "l 1 2\nl 2 3\ncstype bezier\nvn 0 1 0\n")


def test_triangles_of_one_corner_twice_are_dropped(tmp_path):
    mesh = read_text_as_obj(tmp_path, SQUARE.replace("f 1/1 2/2 5/3", "f 1/1 1/1 5/3"))
    np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2], [0, 2, 3]])
    assert mesh.uv.shape == (2, 3, 2)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("v 1 0 0", "v 1 0", "line 4: '1 0' are not 3 usable numbers"),
        ("v 1 0 0", "v 1 0 nan", "line 4"),
        ("v 1 0 0", "v 1 0 1e999", "line 4"),
        ("f 1/1 2/2 5/3", "f 1/1 2/2", "line 16: a face has 2 corners"),
        ("f 1/1 2/2 5/3", "f", "line 16: a face has 0 corners"),
        ("5/3", "6/3", "line 16: index 6 does not exist .*1 to 5"),
        ("5/3", "0/3", "index 0 does not exist"),
        ("5/3", "-6/3", "index -6 does not exist"),
        ("5/3", "5/9", "index 9 does not exist .*1 to 4"),
        ("5/3", "99999999999999999999999", "does not exist"),
        ("5/3", "5/3/1/1", "is not a corner"),
        ("5/3", "five", "'five' is not an index"),
        ("5/3", "/3", "'' is not an index"),
    ],
)
def test_faults_are_reported_with_their_line(tmp_path, old, new, message):
    assert old in SQUARE
    with pytest.raises(BadInput, match=message):
        read_text_as_obj(tmp_path, SQUARE.replace(old, new))


def test_unknown_group_is_reported_with_similar_ones(tmp_path):
    with pytest.raises(BadInput, match=r"no group 'sides' .*side"):
        read_text_as_obj(tmp_path, SQUARE, "sides")


@pytest.mark.parametrize("text", ["v 0 0 0\n", "HIERARCHY\nROOT a\n", "f\n"])
def test_files_without_faces_are_refused(tmp_path, text):
    with pytest.raises(BadInput, match=r"no faces|0 corners"):
        read_text_as_obj(tmp_path, text)


def test_faces_without_a_triangle_are_refused_with_file_and_line(tmp_path):
    with pytest.raises(BadInput, match=r"\.obj, line 3: there is no triangle"):
        read_text_as_obj(tmp_path, "v 0 0 0\nv 1 0 0\nf 1 2 1\n")


# As counted by an independent reader: vertices and triangles.
FILES = {
    "sintel/sintel.obj": (3046, 5952),
    "sintel/sintel-collider.obj": (341, 678),
    "sintel/sintel-eyes.obj": (708, 1408),
    "sintel/sintel-eyelashes.obj": (144, 192),
}


@pytest.mark.parametrize("name", FILES)
def test_real_files_are_read_whole(shared, name):
    mesh = read_polygons(shared / name).mesh
    assert (len(mesh.points), len(mesh.triangles)) == FILES[name]


def test_the_makehuman_body_is_one_closed_component(shared):
    mesh = read_polygons(shared / "body_makehuman" / "base.obj", "body").mesh
    assert len(mesh.points) == 19158 and len(mesh.triangles) == 2 * 13378
    assert np.array_equal(np.unique(mesh.triangles), np.arange(13380))
    corners = mesh.points[mesh.triangles]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume == pytest.approx(54.9, abs=0.05)
