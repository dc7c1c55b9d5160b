"""Values in files of any format: HDF5, NPZ, CSV, Markdown and USD."""

import csv
import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from hairpipe.engine import Workspace
from hairpipe.errors import BadInput
from hairpipe.formats.hdf5 import decode
from hairpipe.formats.values import SUFFIXES, write_csv, write_markdown, write_npz, write_points, write_value
from hairpipe.nodes.write_table import write_table
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


@dataclass(frozen=True)
class Inner:
    """A value within a value."""

    file: np.ndarray
    missing: float | None = None


@dataclass(frozen=True)
class Outer:
    """A value of every kind of entry."""

    inner: Inner
    number: float = 0.25
    count: int = 2**40
    flag: bool = True
    text: str = "Grüße"
    names: tuple[str, ...] = ("a", "", "long name")
    nothing: tuple[str, ...] = ()
    maps: dict[str, np.ndarray] = field(default_factory=lambda: {"scalp/left": np.zeros(2, np.int32)})


def test_everything_is_read_back_under_its_dotted_name(tmp_path):
    points = np.arange(6.0).reshape(2, 3)
    write_npz(tmp_path / "value.npz", Outer(Inner(points)))
    with np.load(tmp_path / "value.npz", allow_pickle=False) as found:
        names = {"inner.file", "number", "count", "flag", "text", "names", "nothing", "maps.scalp/left"}
        assert set(found) == names, "what is None is left out"
        np.testing.assert_array_equal(found["inner.file"], points)
        assert found["maps.scalp/left"].dtype == np.int32
        assert (found["number"], found["count"], found["flag"], found["text"]) == (0.25, 2**40, True, "Grüße")
        assert found["names"].tolist() == ["a", "", "long name"] and found["nothing"].shape == (0,)


@given(
    array=hnp.arrays(
        st.sampled_from([np.float64, np.float32, np.int32, bool]), hnp.array_shapes(min_dims=0, min_side=0)
    )
)
def test_any_array_is_read_back_unchanged(array, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "array.npz"
    write_npz(path, {"array": array})
    with np.load(path) as found:
        np.testing.assert_array_equal(found["array"], array)
        assert found["array"].dtype == array.dtype


def test_equal_values_give_equal_bytes(tmp_path):
    for name in ("one", "two"):
        write_npz(tmp_path / name, Inner(np.arange(3)))
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_unsupported_values_are_refused(tmp_path):
    with pytest.raises(TypeError, match="a object is not stored"):
        write_npz(tmp_path / "value.npz", {"thing": object()})


NAMES = ("scheme, how", "tip [m]", "steps")
ROWS = [('with "tension"', 1 / 3, 7), ("a|b", math.pi * 1e-300, -2), ("nothing", math.nan, 2**53 + 1)]
TABLE = table_of_rows(NAMES, ROWS)


def test_csv_reads_back_to_the_bit(tmp_path):
    write_csv(tmp_path / "table.csv", TABLE)
    with (tmp_path / "table.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    assert tuple(names) == NAMES
    assert [row[0] for row in rows] == [row[0] for row in ROWS]
    np.testing.assert_array_equal([float(row[1]) for row in rows], TABLE["tip [m]"])
    assert [int(row[2]) for row in rows] == [row[2] for row in ROWS]


def test_markdown_has_a_cell_for_every_value(tmp_path):
    write_markdown(tmp_path / "table.md", TABLE)
    assert (tmp_path / "table.md").read_text() == (
        "| scheme, how | tip [m] | steps |\n| --- | ---: | ---: |\n"
        '| with "tension" | 0.3333 | 7 |\n| a\\|b | 3.142e-300 | -2 |\n| nothing | - | 9007199254740993 |\n'
    )


def test_the_node_lays_tables_below_each_other(tmp_path):
    text = write_table((TABLE, TABLE), Workspace(tmp_path), format="markdown", cases=("one", "two")).path.read_text()
    assert text.splitlines()[0] == "| case | scheme, how | tip [m] | steps |"
    assert [line.split(" ")[1] for line in text.splitlines()[2:]] == ["one"] * 3 + ["two"] * 3
    for tables, cases in (((TABLE, table_of_rows(["a"], [[1]])), ()), ((TABLE,), ("one", "two"))):
        with pytest.raises(BadInput):
            write_table(tables, Workspace(tmp_path), cases=cases)


POINTS = np.array([[0.1, 0.2, 0.3], [1e-30, -2.5, 3e8], [1 / 3, 0.0, np.pi]])


def read(path):
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=float)


def test_points_alone_are_read_back_exactly(tmp_path):
    write_points(tmp_path / "points.csv", POINTS)
    header, rows = read(tmp_path / "points.csv")
    assert header == ["x", "y", "z"]
    np.testing.assert_array_equal(rows, POINTS)


def test_point_has_the_index_of_its_strand(tmp_path):
    points, velocities = POINTS.astype(np.float32), (POINTS * 2).astype(np.float32)
    write_points(tmp_path / "hair.csv", points, velocities, np.array([0, 2, 2, 3], np.int32))
    header, rows = read(tmp_path / "hair.csv")
    assert header == ["strand", "x", "y", "z", "vx", "vy", "vz"]
    assert rows[:, 0].tolist() == [0, 0, 2]
    np.testing.assert_array_equal(rows[:, 1:4].astype(np.float32), points)
    np.testing.assert_array_equal(rows[:, 4:].astype(np.float32), velocities)


def test_no_points_give_a_header(tmp_path):
    write_points(tmp_path / "none.csv", np.zeros((0, 3)))
    assert (tmp_path / "none.csv").read_text() == "x,y,z\n"
