"""A spiral that is cut into segments, and hangs."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.accuracy import spiral
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Spiral
from hairpipe.graphs.experiments.studies.accuracy.spiral import cut, rod_of, spiral_table
from hairpipe.graphs.experiments.studies.accuracy.statics import Balance
from hairpipe.graphs.experiments.table.checks import checked
from hairpipe.graphs.experiments.validation.row import Row

ROD = Sample(model="rod")


def test_chords_are_equal_and_curvature_grows():
    rod = rod_of(ROD, Spiral())
    points, length = cut(rod, 0.006, 50)
    chords = np.diff(points, axis=0)
    np.testing.assert_allclose(np.linalg.norm(chords, axis=1), 0.006, rtol=1e-9)
    assert 0.3 < length < 0.302
    bends = np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1) / 0.006**3
    expected = rod.natural_at(length * np.arange(1, 50) / 50)[1]
    np.testing.assert_allclose(bends, expected, rtol=0.02)


@pytest.mark.kernels
def test_errors_of_a_rod_fall_by_the_square_of_its_segments():
    table = spiral_table(ROD, Spiral(), [15, 30], [3.0], 1)
    assert table["no equilibrium"].tolist() == [0, 0]
    coarse, fine = table["error of the way [%]"]
    assert coarse / fine == pytest.approx(4.0, rel=0.1) and fine < 1.0


def test_a_way_without_an_equilibrium_is_missed(monkeypatch):
    monkeypatch.setattr(spiral, "balance", lambda specimen, pose, load, free: Balance(pose, 1.0))
    table = spiral_table(ROD, Spiral(), [15], [3.0], 1)
    assert table["no equilibrium"].tolist() == [2]
    (row,) = checked([table], ["rod"], "error of the way [%]", [1e9], [], ("way", "theory")).rows()
    assert Row(*row).verdict == "missed"
