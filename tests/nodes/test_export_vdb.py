"""The export_vdb node."""

import numpy as np
from hairpipe.nodes.export_vdb import export_vdb

from hairpipe.data import LevelSet
from hairpipe.graph import Time


def test_it_writes_one_file_that_tells_its_frame(openvdb, tmp_path):
    distance = np.linspace(-0.3, 0.3, 9, dtype=np.float32)[None, :, None, None] + np.zeros((1, 9, 9, 9), np.float32)
    surface = LevelSet(
        np.zeros((1, 1, 1), np.int32),
        distance,
        np.ones((1, 9, 9, 9, 3), np.float32),
        np.zeros((2, 2, 2, 4), np.float32),
        np.zeros(3),
        0.1,
        3.0,
    )
    for half in (False, True):
        file = export_vdb(surface, Time(1012, 24.0), tmp_path, half=half)
        assert file.path.parent == tmp_path
        assert not file.companions
        grids = openvdb.readAllGridMetadata(str(file.path))
        assert [grid.name for grid in grids] == ["surface", "vel"]
        assert (grids[0]["frame"], grids[0].saveFloatAsHalf) == (1012, half)
