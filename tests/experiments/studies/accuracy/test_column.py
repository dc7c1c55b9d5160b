"""A strand that stands upright buckles at the weight of Greenhill."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import jv

from hairpipe.graphs.experiments.studies.accuracy.column import GREENHILL, column_table, is_stable
from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import straight_specimen


def test_the_theory_is_the_first_zero_of_a_bessel_function():
    assert brentq(lambda gamma: jv(-1 / 3, 2 / 3 * np.sqrt(gamma)), 4.0, 12.0) == pytest.approx(GREENHILL, abs=1e-6)


@pytest.mark.kernels
def test_a_rod_buckles_at_it():
    specimen = straight_specimen(Sample(model="rod"), 25)
    assert is_stable(specimen, 0.99 * GREENHILL) and not is_stable(specimen, 1.01 * GREENHILL)
    (row,) = column_table(Sample(model="rod"), [25]).rows()
    assert abs(row[-1]) < 0.5
