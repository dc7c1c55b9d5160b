"""Alembic files that PyAlembic and Blender wrote, against analytic motion and against the points that Blender shows."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.alembic import read
from hairpipe.formats.animated_meshes import Instant

alembic3d = pytest.importorskip("alembic3d")
Abc = pytest.importorskip("alembic3d.Abc")
AbcGeom = pytest.importorskip("alembic3d.AbcGeom")
imath = pytest.importorskip("imath")
core = pytest.importorskip("alembic3d.AbcCoreAbstract")
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
CLOCKWISE = [0, 3, 2, 1]
AWAY = np.array([0.0, 0.1, 0.5, 1.0])[:, None] * (1.0, 2.0, -3.0)
SAMPLES = 7


def bent(sample: float) -> np.ndarray:
    return SQUARE + AWAY * (sample / 24) ** 2


def array(kind: Any, values: Any) -> Any:
    made = kind(len(values))
    np.asarray(made)[:] = values
    return made


def write(path: Path, author: Callable[[Any, int], None]) -> Path:
    """Write an archive whose samples are frames from 1001 at 24 per second."""
    archive = Abc.OArchive(str(path))
    author(archive.getTop(), archive.addTimeSampling(core.TimeSampling(1 / 24, 1001 / 24)))
    return path


def add_mesh(
    parent: Any, times: int, name: str, points: Callable[[int], np.ndarray], velocities=None, corners=None
) -> None:
    mesh = AbcGeom.OPolyMesh(parent, name, times)
    for k in range(SAMPLES):
        indices = array(imath.IntArray, CLOCKWISE if corners is None else corners(k))
        sample = AbcGeom.OPolyMeshSchemaSample(array(imath.V3fArray, points(k)), indices, array(imath.IntArray, [4]))
        if velocities:
            sample.setVelocities(array(imath.V3fArray, velocities(k)))
        mesh.getSchema().set(sample)


def add_turn(parent: Any, times: int, name: str) -> Any:
    """A transform by a fourteenth of a turn about Z in a frame, with a displacement and scale."""
    space = AbcGeom.OXform(parent, name, times)
    for k in range(SAMPLES):
        sample = AbcGeom.XformSample()
        sample.setTranslation(imath.V3d(k, 2, 0))
        sample.setZRotation(360.0 / 14 * k)
        sample.setScale(imath.V3d(2, 2, 2))
        space.getSchema().set(sample)
    return space


def at(frame: float, **more: Any) -> Instant:
    return Instant(1001, (frame - 1001) / 24, **more)


@pytest.mark.parametrize("frame", [1001, 1004, 1004.4])
def test_samples_give_points_and_velocities(tmp_path, frame):
    file = write(tmp_path / "a.abc", lambda top, times: add_mesh(top, times, "bent", bent))
    mesh, _ = read(file, None, at(frame))
    np.testing.assert_allclose(mesh.points, bent(frame - 1001), atol=1e-6)
    np.testing.assert_allclose(mesh.velocities, 2 * AWAY * (frame - 1001) / 24, atol=2e-5)
    a, b, c = mesh.points[mesh.triangles[0]]
    assert np.cross(b - a, c - a)[2] > 0.0  # counter-clockwise, though the file is clockwise


def test_moving_parents_move_the_points(tmp_path):
    file = write(
        tmp_path / "a.abc", lambda top, times: add_mesh(add_turn(top, times, "turn"), times, "square", lambda k: SQUARE)
    )
    angle = 2 * np.pi / 14 * 3
    turned = SQUARE @ np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    mesh, _ = read(file, None, at(1004))
    np.testing.assert_allclose(mesh.points, 2 * turned + (3, 2, 0), atol=1e-6)


def test_meshes_are_joined_or_picked_by_a_pattern(tmp_path):
    def author(top: Any, times: int) -> None:
        add_mesh(top, times, "body", bent)
        add_mesh(add_turn(top, times, "garment"), times, "sleeve", bent)

    file = write(tmp_path / "a.abc", author)
    counts = {group: len(read(file, group, at(1002))[0].points) for group in (None, "/body", "/garment", "*/sleeve")}
    assert counts == {None: 8, "/body": 4, "/garment": 4, "*/sleeve": 4}
    shape = read(file, None, at(1002))
    assert shape.mesh.triangles.max() == 7 and shape.owners.tolist() == [0, 0, 1, 1]
    with pytest.raises(BadInput, match=r"a.abc: no mesh at or under \*lash"):
        read(file, "*lash", at(1002))


def test_changed_polygons_are_refused_by_sample(tmp_path):
    def author(top: Any, times: int) -> None:
        add_mesh(top, times, "bent", bent, corners=lambda k: CLOCKWISE if k < 4 else CLOCKWISE[::-1])

    file = write(tmp_path / "a.abc", author)
    read(file, None, at(1003))
    with pytest.raises(BadInput, match=r"a.abc /bent, sample 4: the polygons have changed"):
        read(file, None, at(1004))


def test_other_shapes_are_named(tmp_path):
    def author(top: Any, times: int) -> None:
        add_mesh(top, times, "bent", bent)
        AbcGeom.OPoints(top, "dust", times)

    with pytest.warns(UserWarning, match="/dust, which is not a mesh, is not read"):
        read(write(tmp_path / "a.abc", author), None, at(1001))


def test_a_missing_library_is_named(tmp_path, monkeypatch):
    file = write(tmp_path / "a.abc", lambda top, times: add_mesh(top, times, "bent", bent))
    monkeypatch.setitem(sys.modules, "alembic3d", None)
    with pytest.raises(BadInput, match=r"hairpipe\[alembic\]"):
        read(file, None, at(1001))
