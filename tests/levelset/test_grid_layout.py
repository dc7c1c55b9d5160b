"""The lattice is fixed in the world, holds the band, and is refused where it would be too large."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hairpipe.errors import BadInput
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.values.body import BRICK

numbers = st.floats(-3.0, 3.0)


@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=3, max_size=3), st.floats(0.05, 0.5), st.floats(2, 9))
def test_it_holds_the_band_and_a_sample_more(corners, voxel, half_width):
    lattice = lattice_around(np.array([corners]), voxel, half_width)
    low, high = np.array(corners).min(axis=0), np.array(corners).max(axis=0)
    last = lattice.first + np.array(lattice.samples) - 1
    assert (lattice.first % BRICK == 0).all()
    assert (lattice.first * voxel <= low - (half_width + 1) * voxel + 1e-9).all()
    assert (last * voxel >= high + (half_width + 1) * voxel - 1e-9).all()
    assert np.allclose(lattice.size, (last - lattice.first) * voxel)


def test_a_body_that_moves_by_a_brick_moves_its_lattice_by_one():
    corners = np.array([[[0.1, 0.2, 0.3], [0.7, 0.1, 0.2], [0.5, 0.9, 0.4]]])
    before, after = (lattice_around(corners + np.array(shift), 0.0625, 8.0) for shift in ([0, 0, 0], [0.5, 0, -1.0]))
    assert (after.first - before.first).tolist() == [8, 0, -16]
    assert after.bricks == before.bricks


def test_a_lattice_too_large_is_refused_with_a_voxel_that_fits():
    corners = np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 2.0]]])
    with pytest.raises(BadInput, match=r"would have .* samples at voxel = 0.0002 m") as refusal:
        lattice_around(corners, 2e-4, 8.0)
    fits = float(re.search(r"voxel = ([\d.e-]+) or more", str(refusal.value))[1])
    assert fits < 0.01
    lattice_around(corners, fits, 8.0)
