"""One motion at several frame rates."""

import pytest

from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.nodes.measure_rates import measure_rates
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import StepControl

GROOM = lay_strands(9, 0.05, 4, (1.0, -0.3, 0.0), (0.0, 0.0, 0.01), None, 0.0)
EQUAL, LARGEST = StepControl(1 / 96), StepControl(1.0)


def differences(steps, finer=1):
    settings = {"model": "network", "precision": "double", "every": 0.25, "intervals": 1}
    table = measure_rates(GROOM, None, rates=(24, 48), steps=steps, finer=finer, **settings)
    assert table["time [s]"].tolist() == [0.25, 0.25]
    return table["difference [% of length]"].tolist()


def test_equal_steps_have_one_curve_at_every_rate():
    same, other = differences(EQUAL)
    assert same == 0.0 and other < 1e-6


def test_steps_that_differ_are_seen():
    same, other = differences(LARGEST)
    assert same == 0.0 and other > 1e-3


def test_a_run_in_shorter_steps_is_another_one():
    assert min(differences(EQUAL, finer=4)) > 1e-4


@pytest.mark.parametrize(
    ("rates", "every", "message"),
    [
        ((24, 25), 0.5, "25 frames a second"),
        ((24,), 0.50001, "24 frames a second"),
        ((24,), 4e-4, "24 frames a second"),
        ((24,), 1e-9, "24 frames a second"),
        ((), 0.5, "no frame rates"),
    ],
)
def test_intervals_are_frames_of_every_rate(rates, every, message):
    with pytest.raises(BadInput, match=message):
        measure_rates(GROOM, None, rates=rates, every=every, intervals=1)
