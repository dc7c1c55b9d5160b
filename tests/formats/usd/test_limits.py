"""Foreign stages: what is absent or damaged is refused by name; layers are files; reading ends within limits."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd

from hairpipe.apart import work_apart
from hairpipe.app.cli.commands.files import lint_file
from hairpipe.errors import BadInput
from hairpipe.formats.animated_meshes import Instant
from hairpipe.formats.registry import list_parts, read_body, read_strands
from hairpipe.formats.usd import curves, meshes
from hairpipe.formats.usd.stage import find_layers, open_stage, open_whole

LEVELS = 40


def in_variant(prim: Sdf.PrimSpec, name: str) -> None:
    variant = Sdf.VariantSpec(Sdf.VariantSetSpec(prim, "look"), "long")
    variant.primSpec.referenceList.Prepend(Sdf.Reference(name, "/a"))


def in_clips(prim: Sdf.PrimSpec, field: str, value: object) -> None:
    prim.SetInfo("clips", {"default": {field: value}})


ARCS: dict[str, Callable[[Sdf.PrimSpec, str], object]] = {
    "sublayer": lambda prim, name: prim.layer.subLayerPaths.append(name),
    "reference": lambda prim, name: prim.referenceList.Prepend(Sdf.Reference(name, "/a")),
    "payload": lambda prim, name: prim.payloadList.Prepend(Sdf.Payload(name, "/a")),
    "variant": in_variant,
    "clip": lambda prim, name: in_clips(prim, "assetPaths", Sdf.AssetPathArray([Sdf.AssetPath(name)])),
    "manifest": lambda prim, name: in_clips(prim, "manifestAssetPath", Sdf.AssetPath(name)),
}
"""Ways in which a stage is composed of another file."""


def compose(path: Path, arc: str, name: str) -> Path:
    """Write a layer that refers to another file."""
    layer = Sdf.Layer.CreateNew(str(path))
    ARCS[arc](Sdf.CreatePrimInLayer(layer, "/a"), f"./{name}")
    layer.Save()
    return path


@pytest.mark.parametrize("arc", ARCS)
def test_a_layer_that_is_a_pipe_is_refused_before_it_is_opened(tmp_path: Path, arc: str) -> None:
    os.mkfifo(tmp_path / "pipe.usda")
    inner = compose(tmp_path / "inner.usda", arc, "pipe.usda")
    outer = compose(tmp_path / "outer.usda", "sublayer", "inner.usda")
    for stage in (inner, outer):
        with pytest.raises(BadInput, match=rf"{stage.name}: refers to pipe\.usda, which is a pipe"):
            open_stage(stage)


def test_readers_and_lint_refuse_it(tmp_path: Path) -> None:
    (tmp_path / "zero.usda").symlink_to("/dev/zero")
    path = compose(tmp_path / "a.usda", "reference", "zero.usda")
    for read in (read_body, lambda path: read_strands(path, 1.0, "y", None), lambda path: work_apart(lint_file, path)):
        with pytest.raises(BadInput, match=r"a\.usda: refers to zero\.usda, which is a device"):
            read(path)


def test_layers_are_counted_once_and_with_their_clips(tmp_path: Path) -> None:
    circle = [compose(tmp_path / "a.usda", "reference", "b.usda"), compose(tmp_path / "b.usda", "reference", "a.usda")]
    clips = [compose(tmp_path / "c.usda", "clip", "a.usda"), circle[0]]
    for layers in (circle, clips):
        assert sum(find_layers(layers[0])[1].values()) == sum(layer.stat().st_size for layer in layers)


@pytest.fixture
def doubling(tmp_path: Path) -> Path:
    """Three kilobytes of references that make 2^40 prims."""
    layer = Sdf.Layer.CreateNew(str(tmp_path / "doubling.usda"))
    for level in range(LEVELS):
        for child in "xy":
            prim = Sdf.CreatePrimInLayer(layer, f"/a{level}/{child}")
            prim.referenceList.Prepend(Sdf.Reference("", f"/a{level + 1}"))
    Sdf.CreatePrimInLayer(layer, f"/a{LEVELS}")
    layer.Save()
    return tmp_path / "doubling.usda"


@pytest.mark.parametrize(
    ("limit", "most", "message"),
    [
        ("RLIMIT_DATA", (1 << 28, 1 << 28), "takes more than 0.25 GiB of memory"),
        ("RLIMIT_CPU", (2, -1), "takes more than 60 s of processor time, and 1 s per MB of its files"),
    ],
)
@pytest.mark.slow
def test_references_that_double_at_each_level_end_at_a_limit(
    doubling: Path, limit: str, most: tuple[int, int], message: str
) -> None:
    """Limits of the caller, which are lower than ours, end the same work sooner."""
    script = f"""
import resource, sys
from pathlib import Path
from hairpipe.formats.registry import read_strands

resource.setrlimit(resource.{limit}, {most})
read_strands(Path(sys.argv[1]), 1.0, "y", None)
"""
    child = subprocess.run([sys.executable, "-c", script, doubling], capture_output=True, text=True)
    assert f"doubling.usda: {message}" in child.stderr


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
LOST = {
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


@pytest.mark.parametrize("arc", LOST)
def test_an_absent_file_is_refused_or_named(tmp_path, arc):
    body = MESH.format(name="body")
    inner = write(tmp_path / "inner.usda", f'def "shot" {{\n{body}{LOST[arc]}\n}}')
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
    sets = f'variantSet "look" = {{ "short" {{}} "long" {{\n {LOST["reference"]}\n }} }}'
    off = LOST["payload"].replace("(", "(active = false\n").replace("lost", "off", 1)
    open_whole(write(tmp_path / "shot.usda", f'def "a" ({variants}) {{\n{sets}\n}}\n{off}'), None, "refuse")


def test_a_part_that_another_prim_needs_is_named_only(tmp_path):
    shot = write(tmp_path / "shot.usda", f'def "s" {{\n{MESH.format(name="body")}{LOST["reference"]}\n}}')
    with pytest.warns(UserWarning, match="/s/lost: the reference .* is left out"):
        open_whole(shot, "/s/body", "refuse")
    for prim in ("/s/lost", "/s/lost/mesh", "/s", "*/body"):
        with pytest.raises(BadInput, match="does not exist"):
            open_whole(shot, prim, "refuse")


def test_the_animation_of_the_skeleton_of_a_prim_is_needed(tmp_path):
    rig = 'rel skel:skeleton = </rig>\n def Mesh "body" {}'
    bound = f'def "s" (prepend apiSchemas = ["SkelBindingAPI"]) {{\n{rig}\n}}'
    skeleton = 'def Skeleton "rig" {\n rel skel:animationSource = </lost>\n }'
    shot = write(tmp_path / "shot.usda", f"{bound}\n{skeleton}\n{LOST['reference']}")
    with pytest.raises(BadInput, match="/lost: the reference"):
        open_whole(shot, "/s/body", "refuse")


def test_a_body_and_hair_that_are_referenced_are_read(tmp_path):
    write(tmp_path / "body.usda", MESH.format(name="body"), 'defaultPrim = "body"')
    write(tmp_path / "hair.usda", HAIR, 'defaultPrim = "hair"')
    shot = write(
        tmp_path / "shot.usda", 'def "body" (references = @./body.usda@) {}\ndef "hair" (payload = @./hair.usda@) {}'
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


TEXT = b'#usda 1.0\ndef Xform "a"\n{\n    float b = \n}\n'


def make(name: str, data: bytes) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).write_bytes(data)
        return folder / name

    return write


def folder(parent: Path) -> Path:
    (parent / "a.usd").mkdir()
    return parent / "a.usd"


CASES = {
    "missing": (lambda p: p / "a.usd", "cannot be read: No such file"),
    "folder": (folder, "cannot be read: it is a directory"),
    "empty": (make("a.usda", b""), "the file is empty"),
    "other": (make("a.obj", b"v 0 0 0"), "not named like a USD file"),
    "garbage": (make("a.usd", b"hello"), "not a readable USD file"),
    "header": (make("a.usdc", b"PXR-USDC"), "not a readable USD file"),
    "zip": (make("a.usdz", b"PK\x03\x04 nothing"), "not a readable USD file"),
    "syntax": (make("a.usda", TEXT), "a.usda: not a readable USD file: line 4, column 5: Expected }"),
    "crlf": (
        make("a.usda", TEXT.replace(b"\n", b"\r\n")),
        "a.usda: not a readable USD file: line 4, column 5: Expected }",
    ),
    "latin": (make("a.usda", b'#usda 1.0\ndef Xform "\xe4" {}\n'), "not UTF-8"),
}


@pytest.mark.parametrize(("write", "message"), CASES.values(), ids=CASES)
def test_other_files_are_refused(tmp_path: Path, write: Callable[[Path], Path], message: str) -> None:
    path = write(tmp_path)
    with pytest.raises(BadInput) as caught:
        open_stage(path)
    assert message in str(caught.value) and path.name in str(caught.value) and "\n" not in str(caught.value)


def test_unreadable_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.usda").write_bytes(b"#usda 1.0\n")
    monkeypatch.setattr(os, "access", lambda *_: False)  # whoever may read everything is not refused
    with pytest.raises(BadInput, match=r"a\.usda: the file cannot be read: Permission denied"):
        open_stage(tmp_path / "a.usda")


def write_rates(folder: Path, outer: str, inner: str) -> Path:
    """Write a stage with a sublayer that has samples, with rates of both."""
    (folder / "in.usda").write_text(
        f'#usda 1.0\n({inner}\n)\ndef "x" {{\n double y.timeSamples = {{ 1: 2, 2: 3 }}\n}}\n'
    )
    (folder / "out.usda").write_text(f"#usda 1.0\n({outer}\n subLayers = [@in.usda@]\n)\n")
    return folder / "out.usda"


@pytest.mark.parametrize("rate", ["0", "-24", "nan", "inf"])
@pytest.mark.parametrize("layer", ["out.usda", "in.usda"])
def test_a_rate_that_is_not_positive_is_refused(tmp_path: Path, rate: str, layer: str) -> None:
    rates = {"out.usda": "", "in.usda": ""} | {layer: f"timeCodesPerSecond = {rate}"}
    with pytest.raises(BadInput, match=rf"{layer}: timeCodesPerSecond is {rate}"):
        open_whole(write_rates(tmp_path, *rates.values()), None, "refuse")


def test_layers_of_another_rate_are_named_with_the_remedy(tmp_path: Path) -> None:
    path = write_rates(tmp_path, "", "timeCodesPerSecond = 25")
    message = r"in\.usda has 25 time codes a second, out\.usda 24, as it states none.* multiplied by 0\.96 "
    with pytest.warns(UserWarning, match=message + r"\(timeCodesPerSecond = 25 in out\.usda keeps them"):
        assert open_whole(path, None, "refuse").GetAttributeAtPath("/x.y").GetTimeSamples() == [0.96, 1.92]
