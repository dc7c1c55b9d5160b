"""The table of formats names functions that exist, and each suffix once."""

from collections import Counter
from importlib import import_module
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant
from hairpipe.formats.registry import FORMATS, read_body, read_moving, read_strands, recall_joints, suffixes_of

CONTENTS = ("body", "meshes", "motion", "strands")
FUNCTIONS = sorted({name for form in FORMATS for content in CONTENTS if (name := getattr(form, content))})


@pytest.mark.parametrize("function", FUNCTIONS)
def test_functions_of_the_table_exist_and_take_a_path_first(function: str) -> None:
    module, _, name = function.rpartition(".")
    assert next(iter(signature(getattr(import_module(module), name)).parameters)) == "path"


def test_a_suffix_belongs_to_one_format() -> None:
    assert max(Counter(suffix for form in FORMATS for suffix in form.suffixes).values()) == 1
    assert all(any(getattr(form, content) for content in CONTENTS) for form in FORMATS)
    assert suffixes_of("motion") == (".usd", ".usda", ".usdc", ".usdz", ".gltf", ".glb", ".bvh")


def test_a_file_that_cannot_hold_what_is_asked_for_is_refused_with_those_that_can() -> None:
    with pytest.raises(BadInput, match=r"a\.tfx: meshes are not read from \.tfx files \(\.usd, .*\.ply or \.obj\)"):
        read_moving(Path("a.tfx"), None, None, Instant(0, 0))
    with pytest.raises(BadInput, match=r"a\.obj: motion is not read from \.obj files \(.*\.glb or \.bvh\)"):
        recall_joints(Path("a.obj"), None, None, 24.0)
    with pytest.raises(BadInput, match=r"a\.xgen: hair is not read from \.xgen files \(\.usd, .*, \.obj or \.tfx\)"):
        read_strands(Path("a.xgen"), 1.0, "y", None)
    with pytest.raises(BadInput, match="a BVH file has one clip"):
        recall_joints(Path("a.bvh"), None, "walk", 24.0)


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
