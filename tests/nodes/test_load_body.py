import numpy as np
import pytest

from hairpipe.body.scalp import Scalp
from hairpipe.nodes.load_body import load_body


def test_an_obj_file_becomes_a_body_of_one_joint(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 10 0 0\nv 0 0 10\nv 9 9 9\nf 1 2 3\n")
    body = load_body(file=tmp_path / "a.obj", unit=0.1, up="z", joint="skull")
    assert body.skeleton.names == ("skull",)
    np.testing.assert_allclose(body.mesh.points, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], atol=1e-12)


def test_a_usd_file_without_a_skeleton_becomes_a_body_of_one_joint(tmp_path):
    (tmp_path / "a.usda").write_text(
        """#usda 1.0
        (metersPerUnit = 1)
        def Mesh "triangle"
        {
            point3f[] points = [(0, 1, 0), (1, 1, 0), (1, 2, 0)]
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
        }
        """
    )
    body = load_body(file=tmp_path / "a.usda", joint="skull")
    assert body.skeleton.names == ("skull",)
    np.testing.assert_allclose(body.skeleton.rest[0, :3, 3], [2 / 3, 4 / 3, 0], atol=1e-7)


def test_the_makehuman_body_has_a_rig_and_a_scalp(shared):
    folder = shared / "body_makehuman"
    rig = {"skeleton": folder / "default.mhskel", "weights": folder / "default_weights.mhw"}
    body = load_body(file=folder / "base.obj", group="body", unit=0.1, scalp=Scalp(), **rig)
    assert len(body.mesh.points) == 13380 and len(body.skeleton.names) == 163 and body.weights.shape[1] == 9
    assert np.ptp(body.mesh.points[:, 1]) == pytest.approx(1.666, abs=0.001)
    np.testing.assert_allclose(body.weights.sum(axis=1), 1.0)
    assert 200 < np.count_nonzero(body.maps["scalp"] > 0.5) < 800


def test_the_sintel_bust_is_in_metres(shared):
    body = load_body(file=shared / "sintel" / "sintel.obj")
    assert (len(body.mesh.points), len(body.mesh.triangles)) == (3046, 5952)
    assert body.mesh.points[:, 1].max() == pytest.approx(1.655, abs=0.001)
    assert body.skeleton.names == ("head",)
