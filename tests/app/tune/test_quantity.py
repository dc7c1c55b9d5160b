"""Numbers with units."""

import pytest

from hairpipe.app.tune.measured import Tolerance, read_seconds, read_tolerance
from hairpipe.errors import BadInput


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [("2mm", 2e-3, "m"), (" 1.5 cm ", 1.5e-2, "m"), ("2e-3m", 2e-3, "m"), ("0.5 %", 0.5, "%"), ("10%", 10.0, "%")],
)
def test_a_tolerance_is_a_length_or_a_share(text, value, unit):
    found = read_tolerance(text)
    assert found.value == pytest.approx(value, rel=1e-15) and found.unit == unit


@pytest.mark.parametrize(("text", "value"), [("5s", 5.0), ("250 ms", 0.25), ("1.5min", 90.0)])
def test_a_budget_is_a_time(text, value):
    assert read_seconds(text, "--time") == pytest.approx(value, rel=1e-15)


def test_invalid_tolerances_and_times_are_refused_in_one_message():
    for text in ("", "2", "mm", "-2mm", "0mm", "2 kg", "2mm3", "1,5mm", "nan m", "inf%", "5s"):
        with pytest.raises(BadInput, match=r"^--tolerance: .*2mm"):
            read_tolerance(text)
    for text in ("5", "5mm", "0s", "soon"):
        with pytest.raises(BadInput, match=r"^--budget: .*5s"):
            read_seconds(text, "--budget")


@pytest.mark.parametrize("given", [Tolerance(2e-3, "m"), Tolerance(0.5, "%")])
def test_written_values_can_be_read(given):
    assert read_tolerance(str(given)) == given
