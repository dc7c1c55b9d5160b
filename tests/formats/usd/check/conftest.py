"""A good stage with everything the lint looks at, and OpenVDB files that are one word a grid."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdVol

from hairpipe.errors import BadInput
from hairpipe.formats.usd.check.lint import lint
from hairpipe.formats.usd.shot import Shot, noted, write_clips, write_shot
from hairpipe.values import Groom, Mesh, Strands

SKIN, FIELD = "/shot/char/skin", "/shot/volume/surface"


class Grid(NamedTuple):
    name: str
    grid_class: str


def inspect(path: Path) -> list[Grid]:
    """An OpenVDB file for the lint: one word a grid."""
    if path.read_text() == "broken":
        raise BadInput("not an OpenVDB file", where=path)
    return [Grid(name, "level set") for name in path.read_text().split()]


def add_volume(stage: Usd.Stage) -> None:
    volume = UsdVol.Volume.Define(stage, "/shot/volume")
    field = UsdVol.OpenVDBAsset.Define(stage, FIELD)
    field.CreateFieldNameAttr("surface")
    field.CreateFieldClassAttr("levelSet")
    for frame in range(1001, 1006):
        field.CreateFilePathAttr().Set(Sdf.AssetPath(f"./body.{frame}.vdb"), frame)
    volume.CreateFieldRelationship("surface", field.GetPath())
    volume.CreateExtentAttr([Gf.Vec3f(0), Gf.Vec3f(1)])


def add_character(stage: Usd.Stage) -> None:
    UsdSkel.Root.Define(stage, "/shot/char")
    skeleton = UsdSkel.Skeleton.Define(stage, "/shot/char/skeleton")
    skeleton.CreateJointsAttr(["root"])
    skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)])
    skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)])
    skin = UsdGeom.Mesh.Define(stage, SKIN)
    skin.CreatePointsAttr([Gf.Vec3f(0), Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)])
    skin.CreateFaceVertexCountsAttr([3])
    skin.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    skin.CreateFaceVertexIndicesAttr([0, 1, 2])
    skin.CreateExtentAttr([Gf.Vec3f(0), Gf.Vec3f(1, 1, 0)])
    binding = UsdSkel.BindingAPI.Apply(skin.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(True, 1).Set([0])
    binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])


@pytest.fixture
def stage(tmp_path: Path, shot: Shot) -> Usd.Stage:
    """A good shot with a level set, a character and a prop from another file."""
    for frame in range(1001, 1006):
        (tmp_path / f"body.{frame}.vdb").write_text("surface vel")
    prop = Usd.Stage.CreateNew(str(tmp_path / "prop.usda"))
    prop.SetDefaultPrim(UsdGeom.Xform.Define(prop, "/prop").GetPrim())
    prop.Save()
    write_shot(tmp_path / "shot.usdc", shot)
    stage = Usd.Stage.Open(str(tmp_path / "shot.usdc"))
    stage.DefinePrim("/shot/prop").GetReferences().AddReference("./prop.usda")
    add_volume(stage)
    add_character(stage)
    return stage


@pytest.fixture
def found() -> Callable[[Usd.Stage], list[tuple[str, str]]]:
    """Save a stage and say which rules are broken, and where."""

    def check(stage: Usd.Stage) -> list[tuple[str, str]]:
        stage.Save()
        return [(finding.rule, finding.path) for finding in lint(Path(stage.GetRootLayer().realPath), inspect)]

    return check


FPS, FRAMES = 24.0, range(1001, 1009)
RINGS, SECTORS, RADIUS, CENTRE = 8, 12, 0.1, np.array([0.0, 1.6, 0.0])
STRANDS, POINTS, LENGTH = 30, 6, 0.2


def sphere() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 3), triangles (t, 3) that look outward, and texture coordinates of their corners (t, 3, 2)."""
    v, u = np.meshgrid(np.linspace(0.02, 0.98, RINGS), np.linspace(0, 1, SECTORS + 1), indexing="ij")
    theta, phi = np.pi * v.ravel(), 2 * np.pi * u.ravel()
    points = np.column_stack([np.sin(theta) * np.cos(phi), -np.cos(theta), np.sin(theta) * np.sin(phi)])
    i, j = (x.ravel() for x in np.meshgrid(np.arange(RINGS - 1), np.arange(SECTORS), indexing="ij"))
    a, b = i * (SECTORS + 1) + j, (i + 1) * (SECTORS + 1) + j
    triangles = np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)]).astype(np.int32)
    uv = np.column_stack([u.ravel(), v.ravel()]).astype(np.float32)
    return points * [RADIUS, 1.3 * RADIUS, RADIUS] + CENTRE, triangles, uv[triangles]


SCALP, TRIANGLES, UV = sphere()
RANDOM = np.random.default_rng(7)
TOP = np.flatnonzero(SCALP[TRIANGLES].mean(axis=1)[:, 1] > CENTRE[1] + 0.04)
FACES = RANDOM.choice(TOP, STRANDS).astype(np.int32)
WEIGHTS = RANDOM.dirichlet([2.0, 2.0, 2.0], STRANDS)


def rest() -> np.ndarray:
    """Hair that leaves the skin outward and bends down, all segments of one length."""
    roots = np.einsum("sk,skx->sx", WEIGHTS, SCALP[TRIANGLES[FACES]])
    out = roots - CENTRE
    angle = np.linspace(0, 1.2, POINTS - 1)[None, :, None]
    ways = np.cos(angle) * (out / np.linalg.norm(out, axis=1, keepdims=True))[:, None] - np.sin(angle) * [0.0, 1, 0]
    steps = ways / np.linalg.norm(ways, axis=2, keepdims=True) * (LENGTH / (POINTS - 1))
    return np.concatenate([roots[:, None], roots[:, None] + np.cumsum(steps, axis=1)], axis=1).reshape(-1, 3)


def move(points: np.ndarray, frame: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of points that turn about Y, to and fro, and sway."""
    t = (frame - FRAMES[0]) / FPS
    angle, rate = 0.8 * np.sin(5 * t), 4.0 * np.cos(5 * t)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    moved = points @ turn.T
    sway, drift = np.array([0.05 * np.sin(4 * t), 0, 0.1 * t * t]), np.array([0.2 * np.cos(4 * t), 0, 0.2 * t])
    return moved + sway, np.cross([0, rate, 0], moved) + drift


def hair(frame: int) -> Strands:
    points, velocities = move(rest(), frame)
    offsets = np.arange(0, STRANDS * POINTS + 1, POINTS, dtype=np.int32)
    return Strands(points.astype(np.float32), velocities.astype(np.float32), offsets, 8e-5)


def body(frame: int) -> Mesh:
    points, velocities = move(SCALP, frame)
    return Mesh(points, TRIANGLES, velocities, UV)


def groom() -> Groom:
    uv = np.einsum("sk,skx->sx", WEIGHTS, UV[FACES]).astype(np.float32)
    ids = np.arange(STRANDS, dtype=np.int32) + 100
    return Groom(rest(), hair(1001).offsets, ids, FACES, WEIGHTS, np.zeros((STRANDS, 3, 4)), uv)


NODES = {
    "head": {"type": "load_body", "in": {}, "settings": {"file": {"file": "4f" * 20, "suffix": ".obj"}, "unit": 0.01}},
    "other": {"type": "load_mesh_cache", "in": {}, "settings": {"unit": 1.0}},
    "groom": {"type": "load_groom", "in": {"scalp": "head"}, "settings": {"points": "file", "reach": 0.02}},
    "hair": {
        "type": "simulate_hair",
        "in": {"groom": "groom", "body": "head"},
        "settings": {
            "strain": None,
            "steps": {"longest": 0.02},
            "material": {"diameter": {"value": 8e-5, "map": None, "groups": []}},
        },
    },
    "usd": {
        "type": "export_usd",
        "in": {"hair": "hair.strands", "body": "head", "groom": "groom"},
        "settings": {"curve": "bspline", "hairs": 900, "name": "shot"},
    },
}
"""The graph that the head states."""
SHOT = {"fps": FPS, "first": FRAMES[0], "preroll": 0, "cuts": []}


@pytest.fixture(scope="session")
def head_shot() -> Shot:
    """A head with hair that turns and sways: small, of true size, everything known in closed form."""
    notes = noted("usd", "ab" * 20, SHOT, NODES)
    return Shot({f: hair(f) for f in FRAMES}, {f: body(f) for f in FRAMES}, groom(), FPS, notes=notes)


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory, head_shot: Shot) -> Path:
    """The head, written once in both layouts."""
    folder = tmp_path_factory.mktemp("head")
    write_shot(folder / "shot.usdc", head_shot)
    write_clips(folder / "clips.usdc", head_shot)
    return folder


@pytest.fixture
def head(tmp_path: Path, written: Path) -> Usd.Stage:
    """The head as one file, to plant defects in."""
    shutil.copy(written / "shot.usdc", tmp_path)
    return Usd.Stage.Open(str(tmp_path / "shot.usdc"))


@pytest.fixture
def clips(tmp_path: Path, written: Path) -> Usd.Stage:
    """The head as value clips, to plant defects in."""
    shutil.copytree(written, tmp_path / "all")
    return Usd.Stage.Open(str(tmp_path / "all" / "clips.usdc"))
