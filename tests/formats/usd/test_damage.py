"""Damaged files give a result or one BadInput, whatever is broken in them, and never another exception.

Many files go through one child process; a file of which OpenUSD itself dies is skipped (see test_apart).
"""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdUtils, UsdVol

from hairpipe.formats.usd.shot import Shot, write_clips, write_shot

SCRIPT = """
import sys, warnings
from pathlib import Path
from hairpipe.errors import BadInput
from hairpipe import apart
from hairpipe.formats.usd import curves, meshes
from hairpipe.formats.usd.check.lint import lint

warnings.simplefilter("ignore")
apart.MEMORY = 1 << 30
apart.limit_memory()
for path in map(Path, sys.argv[1:]):
    for work in (lambda: meshes.read_body(path), lambda: curves.read_curves(path), lambda: lint(path)):
        try:
            work()
        except BadInput as fault:
            assert path.name in str(fault) and "\\n" not in str(fault), fault
    print(path, flush=True)
"""
WORDS = [b"0", b"-1", b"3", b"1e300", b"-inf", b"nan", b"99999999999", b'"x"', b"@y@", b"</a>", b"None", b"[]"]
WORDS += [b"int", b"string[]", b"double3", b"matrix4d[]", b"Mesh", b"over", b"Points", b"timeSamples", b"\xe9"]
NUMBERS = 7  # the first of these words

place = st.tuples(st.floats(0, 1), st.integers(0, 255))
damages = st.lists(
    st.tuples(st.sampled_from(["cut", "flip", "word", "number", "line"]), st.lists(place, min_size=1, max_size=4)),
    min_size=25,
    max_size=25,
)


def harm(data: bytes, kind: str, places: list[tuple[float, int]]) -> bytes:
    """Cut the tail off, change bytes, or replace words, replace numbers, leave out lines as text has them."""
    if kind == "cut":
        return data[: int(places[0][0] * len(data))]
    pieces = {
        "flip": lambda: [data[n : n + 1] for n in range(len(data))],
        "word": lambda: re.split(rb"([\w.+-]+)", data),
        "number": lambda: re.split(rb"((?<![\w.])-?[\d.]+(?![\w.]))", data),
        "line": lambda: data.splitlines(keepends=True),
    }[kind]()
    odd = kind in ("word", "number") and len(pieces) > 1
    for at, byte in places:
        new = {"flip": bytes([byte]), "word": WORDS[byte % len(WORDS)], "number": WORDS[byte % NUMBERS], "line": b""}
        pieces[2 * int(at * (len(pieces) // 2 - 1)) + 1 if odd else int(at * (len(pieces) - 1))] = new[kind]
    return b"".join(pieces)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory, shot: Shot) -> list[Path]:
    """A shot with a skinned character and a level set as crate, text and package, and one in clips."""
    folder = tmp_path_factory.mktemp("good")
    write_shot(folder / "shot.usdc", shot)
    stage = Usd.Stage.Open(str(folder / "shot.usdc"))
    UsdSkel.Root.Define(stage, "/shot/char")
    skeleton = UsdSkel.Skeleton.Define(stage, "/shot/char/skeleton")
    skeleton.CreateJointsAttr(["a", "a/b"])
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)] * 2)
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)] * 2)
    skin = UsdGeom.Mesh.Define(stage, "/shot/char/skin")
    skin.CreatePointsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(1, 1, 0), Gf.Vec3f(0, 1, 0)])
    skin.CreateFaceVertexCountsAttr([4])
    skin.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    binding = UsdSkel.BindingAPI.Apply(skin.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * 4)
    binding.CreateJointWeightsPrimvar(False, 2).Set([0.5, 0.5] * 4)
    UsdVol.Volume.Define(stage, "/shot/volume").CreateFieldRelationship("surface", "/shot/volume/surface")
    UsdVol.OpenVDBAsset.Define(stage, "/shot/volume/surface").CreateFilePathAttr(Sdf.AssetPath("./a.vdb"))
    for name in ("all.usdc", "all.usda"):
        stage.Export(str(folder / name))
    UsdUtils.CreateNewUsdzPackage(str(folder / "shot.usdc"), str(folder / "all.usdz"))
    write_clips(folder / "clips.usdc", shot)
    Usd.Stage.Open(str(folder / "clips.usdc")).Export(str(folder / "clips.usda"))
    return [folder / name for name in ("all.usdc", "all.usda", "all.usdz", "clips.usda")]


def survivors(paths: list[Path]) -> None:
    """Read all files; fails on anything but a result, BadInput, or the death of the process."""
    while paths:
        command = [sys.executable, "-c", SCRIPT, *map(str, paths)]
        child = subprocess.run(command, capture_output=True, text=True, errors="replace")
        assert child.returncode <= 0, child.stderr[-3000:]
        paths = paths[len(child.stdout.splitlines()) + 1 :]


def test_the_undamaged_are_read(good: list[Path]) -> None:
    survivors(good)


@settings(max_examples=3, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(damages)
@pytest.mark.slow
def test_damaged_files_are_results_or_bad_input(good: list[Path], damage: list) -> None:
    harmed = []
    for path in good:
        for n, one in enumerate(damage):
            harmed.append(path.with_name(f"{path.stem}_{n}{path.suffix}"))
            harmed[-1].write_bytes(harm(path.read_bytes(), *one))
    survivors(harmed)
