"""How fast the error falls with the step: a smooth motion shows the order that a scheme has.

A swing that is let go of begins with a jolt: no step in use resolves the quick modes that it excites, the ones along
the strand among them, and every scheme of second order then shows 1.2 to 1.9, however well each solve is iterated. A
root that is shaken sets out from rest, and its strand shows 2.
"""

from functools import cache

import numpy as np
import pytest

from hairpipe.graphs.experiments.studies.integrators.follow import RATE, follow
from hairpipe.graphs.experiments.studies.integrators.trial import Trial
from hairpipe.laws.settings import Scheme

SHAKE = Trial(("shake 600 deg/s",), lengths=(0.1,), segments=12, seconds=0.5)
SWING = Trial(("swing",), lengths=(0.3,), segments=12, seconds=0.5)
COUNTS = np.array([5, 10, 20, 40])
"""Steps between two samples."""


@cache
def converged(trial):
    return follow(trial, Scheme(iterations=3), None, 1 / RATE / 320).tips


def errors(trial, scheme):
    """RMS over time of the tip's distance from the converged run [% of length]."""
    tips = [follow(trial, scheme, None, 1 / RATE / count).tips[:, 0] for count in COUNTS]
    away = [np.linalg.norm(found - converged(trial)[:, 0], axis=1) for found in tips]
    return 100 * np.sqrt(np.mean(np.square(away), axis=1)) / trial.lengths[0]


@pytest.mark.parametrize(
    ("trial", "scheme", "least", "most"),
    [
        (SHAKE, Scheme(), 1.8, 2.3),
        (SHAKE, Scheme(iterations=2), 1.8, 2.3),
        (SHAKE, Scheme("bdf2"), 1.7, 2.2),
        (SWING, Scheme("backward_euler", "printed"), 0.8, 1.2),
        (SWING, Scheme("nine_steps", "printed", "full_step"), 0.75, 1.2),
        (SWING, Scheme("nine_steps", "printed", "trapezoid"), 0.8, 1.4),
        (SWING, Scheme("nine_steps", "tension", "trapezoid"), 1.0, 2.2),
    ],
    ids=["tr_bdf2", "twice", "bdf2", "backward_euler", "full_step", "trapezoid", "trapezoid_tension"],
)
def test_error_falls_as_the_order_says(trial, scheme, least, most):
    """The trapezoid as printed is of first order: it moves hair by forces that leave out how springs turn."""
    found = errors(trial, scheme)
    assert least < -np.polyfit(np.log(COUNTS), np.log(found), 1)[0] < most, found


def test_the_default_is_accurate_at_its_step():
    """On a coarse strand: the graph of this experiment has the fine one."""
    found = errors(SHAKE, Scheme())
    assert found[COUNTS == 10] < 0.3 and found[COUNTS == 5] < 1.2
