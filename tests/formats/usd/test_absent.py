"""What a stage names and what does not exist is refused by name; composed stages are read as single files are."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd

from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant
from hairpipe.formats.registry import list_parts
from hairpipe.formats.usd import curves, meshes
from hairpipe.formats.usd.stage import open_whole

MESH = """def Mesh "{name}" {{
    int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1)]
}}
"""
HAIR = """def BasisCurves "hair" {
    uniform token type = "linear"
    int[] curveVertexCounts = [2]
    point3f[] points = [(0, 0, 0), (0, 1, 0)]
}
"""
ARCS = {
    "reference": 'def "lost" (references = @./lost.usda@) {}',
    "payload": 'def "lost" (payload = @./lost.usda@</x>) {}',
    "value clip": 'def "lost" (clips = { dictionary default = { string primPath = "/x"\n asset[] assetPaths = '
    "[@./lost.usda@]\n double2[] active = [(1, 0)] } }) {}",
    "value clip of a template": 'def "lost" (clips = { dictionary default = { string primPath = "/x"\n string '
    'templateAssetPath = "./lost.#.usda"\n double templateStartTime = 1\n double templateEndTime = 2 } }) {}',
}
"""Prims of which a part is in a file that does not exist."""


def write(path: Path, text: str, head: str = "") -> Path:
    path.write_text(f"#usda 1.0\n(\n    metersPerUnit = 1\n    {head}\n)\n{text}\n")
    return path


@pytest.mark.parametrize("arc", ARCS)
def test_an_absent_file_is_refused_or_named(tmp_path, arc):
    body = MESH.format(name="body")
    inner = write(tmp_path / "inner.usda", f'def "shot" {{\n{body}{ARCS[arc]}\n}}')
    shot = write(tmp_path / "shot.usda", "", "subLayers = [@./inner.usda@]")
    message = rf"inner\.usda /shot/lost: the {arc.split(' of')[0]} \S*/lost.*usda.* not exist"
    with pytest.raises(BadInput, match=message) as fault:
        open_whole(shot, None, "refuse")
    assert "\n" not in str(fault.value) and str(inner) in str(fault.value)
    with pytest.warns(UserWarning, match=message):
        assert len(meshes.read_moving(shot, None, Instant(0, 0), "warn").mesh.points) == 4


def test_an_absent_sublayer_is_refused_in_any_layer(tmp_path):
    write(tmp_path / "part.usda", MESH.format(name="body"), 'subLayers = [@./lost.usda@]\n defaultPrim = "body"')
    shot = write(tmp_path / "shot.usda", 'def "a" (references = @./part.usda@) {}')
    with pytest.raises(BadInput, match=r"part\.usda: the sublayer \S*/lost\.usda does not exist"):
        open_whole(shot, "/a", "refuse")


@pytest.mark.parametrize(("target", "message"), [("</no>", "the prim /no"), ("", "a defaultPrim")])
def test_a_reference_to_a_prim_that_is_not_there_is_refused(tmp_path, target, message):
    write(tmp_path / "part.usda", MESH.format(name="body"))
    shot = write(tmp_path / "shot.usda", f'def "a" (references = @./part.usda@{target}) {{}}')
    with pytest.raises(BadInput, match=rf"shot\.usda /a: .*part\.usda does not have {message} of a reference"):
        open_whole(shot, None, "refuse")


def test_a_damaged_reference_is_refused(tmp_path):
    (tmp_path / "part.usda").write_text("nothing")
    shot = write(tmp_path / "shot.usda", 'def "a" (references = @./part.usda@) {}')
    with pytest.raises(BadInput, match=r"the reference .*part\.usda cannot be read"):
        open_whole(shot, None, "refuse")


@pytest.mark.filterwarnings("error")
def test_parts_that_are_not_composed_may_be_absent(tmp_path):
    """Inactive prims, and variants that are not selected."""
    variants = 'variants = { string look = "short" }\n prepend variantSets = "look"'
    sets = f'variantSet "look" = {{ "short" {{}} "long" {{\n {ARCS["reference"]}\n }} }}'
    off = ARCS["payload"].replace("(", "(active = false\n").replace("lost", "off", 1)
    open_whole(write(tmp_path / "shot.usda", f'def "a" ({variants}) {{\n{sets}\n}}\n{off}'), None, "refuse")


def test_a_part_that_another_prim_needs_is_named_only(tmp_path):
    shot = write(tmp_path / "shot.usda", f'def "s" {{\n{MESH.format(name="body")}{ARCS["reference"]}\n}}')
    with pytest.warns(UserWarning, match="/s/lost: the reference .* is left out"):
        open_whole(shot, "/s/body", "refuse")
    for prim in ("/s/lost", "/s/lost/mesh", "/s", "*/body"):
        with pytest.raises(BadInput, match="does not exist"):
            open_whole(shot, prim, "refuse")


def test_the_animation_of_the_skeleton_of_a_prim_is_needed(tmp_path):
    rig = 'rel skel:skeleton = </rig>\n def Mesh "body" {}'
    bound = f'def "s" (prepend apiSchemas = ["SkelBindingAPI"]) {{\n{rig}\n}}'
    skeleton = 'def Skeleton "rig" {\n rel skel:animationSource = </lost>\n }'
    shot = write(tmp_path / "shot.usda", f"{bound}\n{skeleton}\n{ARCS['reference']}")
    with pytest.raises(BadInput, match="/lost: the reference"):
        open_whole(shot, "/s/body", "refuse")


def test_a_body_and_hair_that_are_referenced_are_read(tmp_path):
    write(tmp_path / "body.usda", MESH.format(name="body"), 'defaultPrim = "body"')
    write(tmp_path / "hair.usda", HAIR, 'defaultPrim = "hair"')
    shot = write(
        tmp_path / "shot.usda",
        'def "body" (references = @./body.usda@) {}\ndef "hair" (payload = @./hair.usda@) {}',
    )
    composed, alone = (meshes.read_body(shot.parent / name, "/body") for name in ("shot.usda", "body.usda"))
    assert np.array_equal(composed.mesh.points, alone.mesh.points) and len(alone.mesh.points) == 4
    composed, alone = (curves.read_curves(shot.parent / name, "/hair") for name in ("shot.usda", "hair.usda"))
    assert np.array_equal(composed.points, alone.points) and len(alone.points) == 2


def test_a_file_that_appears_is_one_of_those_that_are_read(tmp_path):
    """Also in a folder that did not exist, where the list of files is known from before."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "shot.usda"))
    stage.DefinePrim("/a").GetReferences().AddReference("./drive/part.usda")
    stage.Save()
    assert list_parts(tmp_path / "shot.usda") == {"": tmp_path / "shot.usda"}
    (tmp_path / "drive").mkdir()
    part = Sdf.Layer.CreateNew(str(tmp_path / "drive" / "part.usda"))
    part.Save()
    assert list_parts(tmp_path / "shot.usda") == {
        "shot.usda": tmp_path / "shot.usda",
        "drive/part.usda": tmp_path / "drive" / "part.usda",
    }
