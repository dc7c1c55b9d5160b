"""Points as CSV tables."""

import csv

import numpy as np

from hairpipe.formats.values import write_points

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
