import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.registry import read_body

TRIANGLE = "g a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_an_obj_file_alone_has_no_joints(tmp_path):
    path = tmp_path / "a.OBJ"
    path.write_text(TRIANGLE)
    body = read_body(path)
    assert body.skeleton.names == () and body.weights.shape == (3, 0)


def test_half_a_rig_is_refused(tmp_path):
    with pytest.raises(BadInput, match="both or neither"):
        read_body(tmp_path / "a.obj", skeleton=tmp_path / "a.mhskel")


@pytest.mark.parametrize("name", ["a.fbx", "a", "a.obj.gz"])
def test_other_formats_are_named(tmp_path, name):
    with pytest.raises(BadInput, match=r"\.usd, .*\.ply or \.obj"):
        read_body(tmp_path / name)


def test_a_usd_file_is_read_and_brings_its_own_rig(tmp_path):
    path = tmp_path / "a.usda"
    path.write_text(
        '#usda 1.0\n(\n    metersPerUnit = 0.01\n    upAxis = "Y"\n)\n'
        'def Mesh "m"\n{\n    int[] faceVertexCounts = [3]\n    int[] faceVertexIndices = [0, 1, 2]\n'
        "    point3f[] points = [(0, 0, 0), (100, 0, 0), (0, 100, 0)]\n}\n"
    )
    body = read_body(path)
    np.testing.assert_allclose(np.ptp(body.mesh.points, axis=0), [1.0, 1.0, 0.0], atol=1e-6)
    with pytest.raises(BadInput, match="contain their skeleton"):
        read_body(path, skeleton=path, weights=path)
