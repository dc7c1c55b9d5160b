"""A spiral that is cut into segments, and hangs."""

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample, Spiral
from hairpipe.graphs.experiments.studies.accuracy.spiral import cut, rod_of, spiral_table

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
    coarse, fine = spiral_table(ROD, Spiral(), [15, 30], [3.0], 1)["error of the way [%]"]
    assert coarse / fine == pytest.approx(4.0, rel=0.1) and fine < 1.0
