"""Values in files of any format, told by the suffix."""

import numpy as np
import pytest

from hairpipe.errors import BadInput
from hairpipe.formats.hdf5 import decode
from hairpipe.formats.values import SUFFIXES, write_value
from hairpipe.values import Body, LevelSet, Mesh, Skeleton, Strands
from hairpipe.values.table import table_of_rows

MESH = Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
HAIR = Strands(np.eye(3, dtype=np.float32), np.zeros((3, 3), np.float32), np.array([0, 3], np.int32), 8e-5)
BODY = Body(
    MESH,
    Skeleton(("root",), np.array([-1], np.int32), np.eye(4)[None], np.zeros((1, 3))),
    np.zeros((3, 1), np.int32),
    np.ones((3, 1)),
)
SPACE = LevelSet(
    np.zeros((1, 1, 1), np.int32),
    np.zeros((1, 9, 9, 9), np.float32),
    np.zeros((1, 9, 9, 9, 3), np.float32),
    np.zeros((2, 2, 2, 4), np.float32),
    np.zeros(3),
    0.01,
    8.0,
)


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".H5", ".USDA"])
@pytest.mark.parametrize("value", [MESH, HAIR, BODY], ids=["mesh", "hair", "body"])
def test_shapes_have_every_form(value, suffix, tmp_path):
    write_value(tmp_path / "new" / f"value{suffix}", value, 1001, 24.0)
    assert [path.name for path in (tmp_path / "new").iterdir()] == [f"value{suffix}"]


def test_a_table_is_csv_too(tmp_path):
    for suffix in (".csv", ".npz", ".h5"):
        write_value(tmp_path / f"value{suffix}", table_of_rows(["time [s]", "case"], [(0.5, "a")]), 1, 24.0)
    assert (tmp_path / "value.csv").read_text() == "time [s],case\n0.5,a\n"


def test_hdf5_is_what_the_store_writes(tmp_path):
    write_value(tmp_path / "value.h5", SPACE, 1, 24.0)
    assert decode(tmp_path / "value.h5", LevelSet).voxel == 0.01


@pytest.mark.parametrize("suffix", [".csv", ".usd"])
def test_values_without_points_are_refused(suffix, tmp_path):
    with pytest.raises(BadInput, match=r"a LevelSet has no points to write \(.h5 or .npz\)"):
        write_value(tmp_path / f"value{suffix}", SPACE, 1, 24.0)


@pytest.mark.parametrize("name", ["value.txt", "value", "value.npz.gz"])
def test_an_unknown_suffix_is_refused_with_those_known(name, tmp_path):
    with pytest.raises(BadInput, match=r"\.h5, .hdf5, .npz, .csv, .usd, .usda, .usdc"):
        write_value(tmp_path / name, MESH, 1, 24.0)
    assert not list(tmp_path.iterdir())


def test_a_failure_leaves_the_file_unchanged(tmp_path):
    path = tmp_path / "value.usda"
    write_value(path, HAIR, 1, 24.0)
    before = path.read_bytes()
    broken = Strands(HAIR.points * np.nan, HAIR.velocities, HAIR.offsets, 8e-5)
    with pytest.raises(BadInput, match="not finite"):
        write_value(path, broken, 1, 24.0)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]
