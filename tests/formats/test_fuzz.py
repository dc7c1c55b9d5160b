"""Damaged files of every format end in a value or one BadInput, in little time and memory, and in no other way.

The child that reads them has lower limits than in use, since the files are small. Formats whose readers are libraries
(OpenUSD, Alembic) may crash it or exceed these, which ends in a message; ours must not.

`python -m tests.formats.test_fuzz FORMAT NUMBER` tries so many of a format, or of `all`, and prints what came of them.
"""

import base64
import json
import random
import re
import struct
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hairpipe import apart, child
from hairpipe.apart import work_apart
from hairpipe.errors import BadInput
from hairpipe.formats import vdb
from hairpipe.formats.animated_meshes import Instant
from hairpipe.formats.bvh import read_bvh
from hairpipe.formats.makehuman import read_skeleton, read_weights
from hairpipe.formats.pictures import read_image
from hairpipe.formats.registry import read_body, read_moving, read_strands, recall_joints
from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.vdb import density_grids, read_voxels
from hairpipe.values import Density, Mesh
from tests.formats.mocap.test_bvh import PLAIN
from tests.formats.test_makehuman import NAMES, RIG, WEIGHTS

SAMPLE = 60
"""Number of damages of each format in the tests; 8 for formats that libraries read."""
MEMORY, SECONDS = 1 << 30, 5
"""Limits of a child that reads damaged files of a few kB [bytes, s of processor time]."""
NUMBERS = ["0", "-1", "3", "1e9", "1e300", "NaN", "-inf", "99999999999", '"x"', "[]", "null", "{}"]
POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\ng a\nf 1/1 2/1 3/1 4/1\nl 1 2 3\n"
PLY = """ply
format {} 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""
USDA = """#usda 1.0
(
  metersPerUnit = 1
  upAxis = "Y"
)
def Mesh "m" {
  int[] faceVertexCounts = [4]
  int[] faceVertexIndices = [0, 1, 2, 3]
  point3f[] points.timeSamples = { 1: [(0,0,0),(1,0,0),(1,1,0),(0,1,0)], 2: [(0,0,1),(1,0,1),(1,1,1),(0,1,1)] }
}
"""


def gltf_of() -> bytes:
    """A triangle whose node moves, in one JSON."""
    from tests.formats.gltf.test_gltf import turning

    return json.dumps(turning("LINEAR", np.array([0.0, 1.0]), POINTS[:2].astype(float), "translation")).encode()


def skinned_of() -> bytes:
    """A strip with joints and morph targets, in one JSON."""
    from tests.formats.gltf.test_gltf import morphing

    return json.dumps(morphing([0.5, 0.0])).encode()


def glb_of() -> bytes:
    """The same with a binary buffer."""
    content = json.loads(skinned_of())
    data = base64.b64decode(content["buffers"][0].pop("uri").partition(",")[2])
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4s2I", b"glTF", 2, 12 + len(chunks)) + chunks


def image_of(folder: Path, suffix: str = "png") -> bytes:
    Image.fromarray(np.arange(256, dtype=np.uint8).reshape(16, 16)).save(folder / f"seed.{suffix}")
    return (folder / f"seed.{suffix}").read_bytes()


def abc_of(folder: Path) -> bytes:
    """A square that moves."""
    from tests.formats.mesh_cache.test_alembic_meshes import SQUARE, add_mesh, write

    write(folder / "seed.abc", lambda top, times: add_mesh(top, times, "m", lambda k: SQUARE + k))
    return (folder / "seed.abc").read_bytes()


def curves_of(folder: Path) -> bytes:
    """Strands with the attributes of Unreal's specification."""
    from tests.formats.strands.test_alembic import groom, write

    write(folder / "seed.abc", groom)
    return (folder / "seed.abc").read_bytes()


def vdb_of(folder: Path) -> bytes:
    """A fog of two leaves."""
    length = np.arange(1, 10 * 4 * 4 + 1, dtype=np.float32).reshape(10, 4, 4)
    fog = Density(np.array([-3, 1, 2], np.int32), 0.01, length, np.zeros((*length.shape, 3), np.float32))
    vdb.write(folder / "seed.vdb", density_grids(fog)[:1], 3)
    return (folder / "seed.vdb").read_bytes()


def usdz_of(folder: Path) -> bytes:
    from pxr import UsdUtils

    usdc_of(folder)
    UsdUtils.CreateNewUsdzPackage(str(folder / "seed.usdc"), str(folder / "seed.usdz"))
    return (folder / "seed.usdz").read_bytes()


def usdc_of(folder: Path) -> bytes:
    from pxr import Sdf

    (folder / "seed.usda").write_text(USDA)
    Sdf.Layer.FindOrOpen(str(folder / "seed.usda")).Export(str(folder / "seed.usdc"))
    return (folder / "seed.usdc").read_bytes()


def shot_of(folder: Path, suffix: str) -> bytes:
    """A shot of hair on a body, with a skinned character and a level set."""
    from pxr import Usd

    from hairpipe.formats.usd.shot import Shot, write_shot
    from tests.formats.usd.check.conftest import add_character, add_volume
    from tests.formats.usd.conftest import FPS, Spun, body, groom, hair

    write_shot(folder / "seed.usdc", Shot(Spun(hair, 2), Spun(body, 2), groom(), FPS))
    stage = Usd.Stage.Open(str(folder / "seed.usdc"))
    add_volume(stage)
    add_character(stage)
    stage.Export(str(folder / f"all.{suffix}"))
    return (folder / f"all.{suffix}").read_bytes()


def clips_of(folder: Path) -> bytes:
    """A shot of hair on a body in value clips."""
    from pxr import Usd

    from hairpipe.formats.usd.shot import Shot, write_clips
    from tests.formats.usd.conftest import FPS, Spun, body, groom, hair

    write_clips(folder / "clips.usdc", Shot(Spun(hair, 2), Spun(body, 2), groom(), FPS))
    Usd.Stage.Open(str(folder / "clips.usdc")).Export(str(folder / "all.usda"))
    return (folder / "all.usda").read_bytes()


def check_mesh(mesh: Mesh) -> None:
    assert np.isfinite(mesh.points).all()
    assert mesh.triangles.min(initial=0) >= 0 and mesh.triangles.max(initial=0) < len(mesh.points)


def moving(path: Path) -> object:
    body, moved = read_body(path), read_moving(path, None, None, Instant(0, 0.02))
    check_mesh(body.mesh)
    check_mesh(moved.mesh)
    return body, moved


def joints(path: Path) -> object:
    return moving(path), recall_joints(path, None, None, 24.0)


def hair(path: Path) -> object:
    found = read_strands(path, 1.0, "y", None)
    assert found.offsets[-1] == len(found.points) and len(found.ids) == len(found.offsets) - 1
    assert found.widths is None or len(found.widths) == len(found.points)
    return found


def shot(path: Path) -> object:
    return read_body(path), hair(path), work_apart(lint, path)


def clip(path: Path) -> object:
    found = read_bvh(path)
    assert np.isfinite(found.values).all() and np.isfinite(found.offsets).all()
    return found


def picture(path: Path) -> object:
    values = read_image(path)
    assert values.ndim == 2 and values.min() >= 0 and values.max() <= 1
    return values


def rig(path: Path) -> object:
    skeleton = work_apart(read_skeleton, path, POINTS)
    assert np.isfinite(skeleton.rest).all()
    return skeleton


def weights(path: Path) -> object:
    joints, shares = work_apart(read_weights, path, NAMES, 4)
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    return joints


def fog(path: Path) -> object:
    return read_voxels(path, "density")


FACE = struct.pack("<B4i", 4, 0, 1, 2, 3)
TFX = struct.pack("<f2I", 4.0, 2, 2) + struct.pack("<I", 160) + bytes(144) + np.ones((4, 4), "<f4").tobytes()
HAIR = (
    struct.pack("<4s4I5f88s", b"HAIR", 2, 4, 3, 0, 0.1, 0, 1, 1, 1, b"") + struct.pack("<2H", 1, 1) + POINTS.tobytes()
)
DATA = b"".join([struct.pack("<i", 2), *(struct.pack("<i", 2) + POINTS[:2].tobytes() for _ in range(2))])
BIN = struct.pack("<2i", 1, 2) + np.arange(14, dtype="<f4").tobytes()
FORMATS: dict[str, tuple[Callable[[Path], bytes], Callable[[Path], object]]] = {
    "obj": (lambda _: OBJ.encode(), lambda path: (moving(path), hair(path))),
    "ply": (lambda _: (PLY.format("ascii") + "0 0 0 1 0 0 1 1 0 0 1 0\n4 0 1 2 3\n").encode(), moving),
    "binary.ply": (lambda _: PLY.format("binary_little_endian").encode() + POINTS.tobytes() + FACE, moving),
    "gltf": (lambda _: gltf_of(), joints),
    "skinned.gltf": (lambda _: skinned_of(), joints),
    "glb": (lambda _: glb_of(), joints),
    "abc": (abc_of, moving),
    "usda": (lambda _: USDA.encode(), moving),
    "usdc": (usdc_of, moving),
    "bvh": (lambda _: PLAIN.encode(), clip),
    "tfx": (lambda _: TFX, hair),
    "hair": (lambda _: HAIR, hair),
    "data": (lambda _: DATA, hair),
    "bin": (lambda _: BIN, hair),
    "curves.abc": (curves_of, hair),
    "usdz": (usdz_of, moving),
    "vdb": (vdb_of, fog),
    "mhskel": (lambda _: json.dumps(RIG).encode(), rig),
    "mhw": (lambda _: json.dumps(WEIGHTS).encode(), weights),
    "png": (image_of, picture),
    "jpg": (lambda folder: image_of(folder, "jpg"), picture),
    "tif": (lambda folder: image_of(folder, "tif"), picture),
    "shot.usda": (lambda folder: shot_of(folder, "usda"), shot),
    "shot.usdc": (lambda folder: shot_of(folder, "usdc"), shot),
    "clips.usda": (clips_of, shot),
}
"""Seed and readers by the end of a file's name."""
LIBRARIES = {"usda", "usdc", "usdz", "abc", "curves.abc", "shot.usda", "shot.usdc", "clips.usda"}
"""Formats that are parsed by libraries in native code."""
TILED = {"vdb"}
"""Formats in which some bytes may stand for millions of values: tiles of OpenVDB."""


def damaged(data: bytes, chance: random.Random) -> bytes:
    """Change bytes, cut the end, double or leave out a part, or put another number in place of one."""
    place, other = (chance.randrange(len(data)) for _ in range(2))
    begin, end = min(place, other), max(place, other)
    kind = chance.choice(["bytes", "bytes", "cut", "double", "omit", "number", "number", "word"])
    if kind == "cut":
        return data[:place]
    if kind in ("double", "omit"):
        return data[:begin] + (data[begin:end] * 2 if kind == "double" else b"") + data[end:]
    if kind == "bytes":
        changed = bytearray(data)
        for _ in range(chance.randint(1, 4)):
            changed[chance.randrange(len(data))] = chance.choice([0, 1, 127, 128, 255, chance.randrange(256)])
        return bytes(changed)
    found = list(re.finditer(rb"-?\d[\d.]*" if kind == "number" else rb"[\w.]+", data))
    if not found:
        return data[:begin]
    match = chance.choice(found)
    return data[: match.start()] + chance.choice(NUMBERS).encode() + data[match.end() :]


def places_of(content: Any) -> Iterator[tuple[Any, Any]]:
    """Yield all objects and lists in a JSON, with the keys of each."""
    for key in content if isinstance(content, dict) else range(len(content)) if isinstance(content, list) else ():
        yield content, key
        yield from places_of(content[key])


def damaged_json(data: bytes, chance: random.Random) -> bytes:
    """Replace a value in a JSON, or leave out a member or an item."""
    content = json.loads(data)
    places = list(places_of(content))
    inside, key = chance.choice(places)
    other, at = chance.choice(places)
    if chance.random() < 0.25:
        del inside[key]
    else:
        inside[key] = chance.choice(
            [0, -1, 1, 7, 0.5, 1e9, 10**400, True, "x", "\ud800", [], [[]], {}, None, json.loads(json.dumps(other[at]))]
        )
    return json.dumps(content).encode()


@contextmanager
def limited() -> Iterator[None]:
    """Let children have the limits of this module."""
    boot = f"from hairpipe import apart; apart.MEMORY, apart.SECONDS = {MEMORY}, {SECONDS}; apart.serve()"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(apart, "command", lambda _: child.command(boot))
        patch.setattr(apart, "_kept", [])
        yield
        while apart._kept:
            apart._kept.pop().end(kill=True)


def outcomes(name: str, number: int, folder: Path, seed: int = 0) -> Counter[str]:
    """Read damaged files of a format; return how many gave a value and how many a message.

    AssertionError, with the file kept, for any other end, and for one of a format of ours beyond the limits.
    """
    make, read = FORMATS[name]
    good = make(folder)
    path = folder / f"seed_and.{name}"
    path.write_bytes(good)
    read(path)
    chance = random.Random(f"{name} {seed}")
    found = Counter[str]()
    for _ in range(number):
        is_json = good.startswith(b"{") and chance.random() < 0.5
        path.write_bytes((damaged_json if is_json else damaged)(good, chance))
        begun = time.process_time()
        try:
            read(path)
            found["values"] += 1
        except BadInput as fault:
            text = str(fault)
            assert "\n" not in text and path.name in text, text
            defended = "not a readable" in text and "Error: " in text
            assert name in LIBRARIES or not defended, text
            found["last defence" if defended else "messages"] += 1
            found["crashes"] += (crashed := "the reader crashes" in text)
            found["beyond limits"] += (excessive := "takes more than" in text)
            assert name in LIBRARIES or not crashed, text
            assert name in LIBRARIES | TILED or not excessive, text
        assert time.process_time() - begun < SECONDS
    return found


@pytest.fixture(scope="module", autouse=True)
def _limited() -> Iterator[None]:
    with limited():
        yield


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.filterwarnings("ignore")
def test_damaged_files_are_values_or_one_message(tmp_path: Path, name: str):
    if name.endswith("abc"):
        pytest.importorskip("alembic3d")
    number = 8 if name in LIBRARIES | TILED else SAMPLE
    assert sum(outcomes(name, number, tmp_path).values()) >= number


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    for one in FORMATS if sys.argv[1] == "all" else sys.argv[1:2]:
        with tempfile.TemporaryDirectory() as place, limited():
            print(one, dict(outcomes(one, int(sys.argv[2]), Path(place))), flush=True)
