"""Foreign stages have limits: their layers are files, and reading them ends within a time and a memory."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Sdf

from hairpipe.apart import work_apart
from hairpipe.app.cli.commands.files import lint_file
from hairpipe.errors import BadInput
from hairpipe.formats.registry import read_body, read_strands
from hairpipe.formats.usd.stage import find_layers, open_stage

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
