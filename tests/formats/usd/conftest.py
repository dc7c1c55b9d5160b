"""A small shot of known motion, and stages to read, built with pxr itself."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from hairpipe.formats.usd.shot import Shot
from hairpipe.values import Groom, Mesh, Strands

FPS, STRANDS, POINTS = 24.0, 6, 5
OFFSETS = np.arange(0, STRANDS * POINTS + 1, POINTS, dtype=np.int32)
TETRAHEDRON = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)


def turn(frame: int) -> np.ndarray:
    """Rotation about Y by one radian a second."""
    angle = (frame - 1001) / FPS
    return np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])


def spin(points: np.ndarray, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of points that turn about Y: v = (0, 1, 0) x p."""
    moved = points @ turn(frame).T
    return moved, np.cross([0.0, 1.0, 0.0], moved)


RANDOM = np.random.default_rng(3)
TRIANGLES = np.arange(STRANDS, dtype=np.int32) % len(FACES)
BARYCENTRICS = RANDOM.dirichlet([2.0, 2.0, 2.0], STRANDS)
UV = np.linspace(0, 1, 24, dtype=np.float32).reshape(4, 3, 2)


def rest() -> np.ndarray:
    roots = np.einsum("sk,skx->sx", BARYCENTRICS, TETRAHEDRON[FACES[TRIANGLES]])
    return (roots[:, None] + np.linspace(0, 0.2, POINTS)[None, :, None] * np.array([0.6, -0.8, 0.0])).reshape(-1, 3)


def hair(frame: int) -> Strands:
    points, velocities = spin(rest(), frame)
    return Strands(points.astype(np.float32), velocities.astype(np.float32), OFFSETS, 8e-5)


def body(frame: int) -> Mesh:
    points, velocities = spin(TETRAHEDRON, frame)
    return Mesh(points, FACES, velocities, UV)


def groom() -> Groom:
    frames, uv = np.zeros((STRANDS, 3, 4)), np.einsum("sk,skx->sx", BARYCENTRICS, UV[TRIANGLES])
    ids = np.arange(10, 10 + STRANDS, dtype=np.int32)
    return Groom(rest(), OFFSETS, ids, TRIANGLES, BARYCENTRICS, frames, uv.astype(np.float32))


class Spun(dict):
    """What turns, at frames 1001 and on; a value is made when it is asked for."""

    def __init__(self, value: Callable[[int], object], count: int) -> None:
        super().__init__({1001 + n: None for n in range(count)})
        self.value = value

    def __getitem__(self, frame: int) -> object:
        return self.value(frame)


@pytest.fixture(scope="session")
def shot() -> Shot:
    """Six hairs on a tetrahedron that turns, five frames."""
    return Shot(Spun(hair, 5), Spun(body, 5), groom(), FPS)


@pytest.fixture
def new_stage(tmp_path: Path) -> Callable[..., Usd.Stage]:
    """Make an empty stage file."""

    def make(up: str = "Y", scale: float = 1.0, name: str = "given.usda") -> Usd.Stage:
        stage = Usd.Stage.CreateNew(str(tmp_path / name))
        UsdGeom.SetStageUpAxis(stage, up)
        UsdGeom.SetStageMetersPerUnit(stage, scale)
        return stage

    return make


@pytest.fixture
def saved() -> Callable[[Usd.Stage], Path]:
    """Save a stage and say where it is."""

    def save(stage: Usd.Stage) -> Path:
        stage.Save()
        return Path(stage.GetRootLayer().realPath)

    return save
