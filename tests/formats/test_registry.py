"""The table of formats names functions that exist, and each suffix once."""

from collections import Counter
from importlib import import_module
from inspect import signature
from pathlib import Path

import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant
from hairpipe.formats.registry import FORMATS, read_moving, recall_joints, suffixes_of

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
    with pytest.raises(BadInput, match="a BVH file has one clip"):
        recall_joints(Path("a.bvh"), None, "walk", 24.0)
