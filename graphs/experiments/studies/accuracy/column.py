"""A strand that stands upright: the weight at which it buckles, compared with Greenhill's.

rho A g L^3 / (E I) = 7.8373 (Greenhill 1881; the first zero of a Bessel function of order -1/3).
"""

from collections.abc import Sequence

import numpy as np

from hairpipe.graphs.experiments.studies.accuracy.sample import Sample
from hairpipe.graphs.experiments.studies.accuracy.specimen import Specimen, straight_specimen
from hairpipe.graphs.experiments.studies.accuracy.statics import balance, least_stiffness, motions
from hairpipe.values import Table
from hairpipe.values.table import table_of_rows

GREENHILL = 7.837347
_STEPS = 12
"""Halvings of the range of Gamma, from nothing to twice the theory: what is found is within 0.025 % of it."""
COLUMNS = ("strand", "segments", "theory", "strand Gamma", "error [%]")


def column_table(sample: Sample, segments: Sequence[int]) -> Table:
    """Tabulate the largest Gamma at which a strand stands upright and stable."""
    rows = []
    for count in segments:
        found = critical_weight(straight_specimen(sample, count))
        rows.append((sample.name(count), count, GREENHILL, found, 100 * (found / GREENHILL - 1)))
    return table_of_rows(COLUMNS, rows)


def critical_weight(specimen: Specimen) -> float:
    """Find the Gamma at which the smallest stiffness of an upright strand is zero, by bisection."""
    lightest = 0.0
    heaviest = 2.0 * GREENHILL
    for _ in range(_STEPS):
        middle = 0.5 * (lightest + heaviest)
        if is_stable(specimen, middle):
            lightest = middle
        else:
            heaviest = middle
    return 0.5 * (lightest + heaviest)


def is_stable(specimen: Specimen, gamma: float) -> bool:
    """Whether an upright strand has a stable equilibrium near its rest shape."""
    length = specimen.segment * specimen.segments
    unit = specimen.material.bending / (specimen.material.line_density * length**3)
    free = motions(specimen)
    at = balance(specimen, specimen.rest, specimen.weight(np.array([0.0, 0.0, -gamma * unit])), free)
    aside = np.abs(at.pose.x - specimen.rest.x).max()
    if not at.found or aside > 0.1 * length:
        return False
    return least_stiffness(specimen, at.pose, free) > 0.0
