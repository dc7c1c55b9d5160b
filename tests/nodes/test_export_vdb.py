"""The export_vdb node."""

import numpy as np
import pytest

from hairpipe.engine import Time
from hairpipe.errors import BadInput
from hairpipe.nodes.export_vdb import export_vdb
from hairpipe.values import Density, LevelSet

FOG = Density(np.array([-3, 0, 5], np.int32), 0.01, np.ones((2, 3, 2), np.float32), np.ones((2, 3, 2, 3), np.float32))


@pytest.fixture
def surface():
    distance = np.linspace(-0.3, 0.3, 9, dtype=np.float32)[None, :, None, None] + np.zeros((1, 9, 9, 9), np.float32)
    return LevelSet(
        np.zeros((1, 1, 1), np.int32),
        distance,
        np.ones((1, 9, 9, 9, 3), np.float32),
        np.zeros((2, 2, 2, 4), np.float32),
        np.zeros(3),
        0.1,
        3.0,
    )


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("fog", [None, FOG], ids=["surface", "both"])
def test_file_states_its_frame(openvdb, surface, fog, half, tmp_path):
    file = export_vdb(surface, fog, Time(1012, 24.0), tmp_path, half=half)
    assert file.path.parent == tmp_path
    assert not file.companions
    grids = {grid.name: grid for grid in openvdb.readAllGridMetadata(str(file.path))}
    assert grids.keys() == {"surface", "vel"} | ({"density", "hair_vel"} if fog else set())
    assert all((grid["frame"], grid.saveFloatAsHalf) == (1012, half) for grid in grids.values())


def test_a_density_alone_is_a_fog(openvdb, tmp_path):
    density, _ = openvdb.readAllGridMetadata(str(export_vdb(None, FOG, Time(3, 24.0), tmp_path).path))
    assert density.gridClass == openvdb.GridClass.FOG_VOLUME


def test_no_hair_is_a_file_without_voxels(openvdb, tmp_path):
    nothing = Density(np.zeros(3, np.int32), 0.01, np.zeros((0, 0, 0), np.float32), np.zeros((0, 0, 0, 3), np.float32))
    path = export_vdb(None, nothing, Time(3, 24.0), tmp_path).path
    assert openvdb.read(str(path), gridname="density").activeVoxelCount() == 0


def test_nothing_connected_is_refused(tmp_path):
    with pytest.raises(BadInput, match=r"nothing is connected \(in.surface, in.density or both\)"):
        export_vdb(None, None, Time(3, 24.0), tmp_path)
