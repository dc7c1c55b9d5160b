"""Restarts from a reference's own states."""

import numpy as np
import pytest

from hairpipe.engine import Frames, Time
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.measure.restarts import restart_frames
from hairpipe.graphs.experiments.nodes.restart_hair import restart_hair
from hairpipe.groom.strands import lay_strands
from hairpipe.laws.settings import StepControl
from hairpipe.nodes.simulate_hair import simulate_hair
from hairpipe.strands.hair_model import build_models
from hairpipe.strands.material import Material

GROOM = lay_strands(9, 0.05, 4, (1.0, -0.3, 0.0), (0.0, 0.0, 0.01), None, 0.0)
FPS, COUNT = 24.0, 7
NUMBERS = tuple(range(1, COUNT + 1))
STEPS = StepControl(1 / 240)


@pytest.fixture(scope="module")
def shot():
    """A reference: its states and its strands."""
    models = build_models(GROOM, Material(), "network")
    found, previous = {}, None
    for frame in NUMBERS:
        hair = simulate_hair(
            GROOM,
            None,
            None,
            None,
            None,
            None,
            None,
            previous,
            Time(frame, FPS),
            (),
            models,
            precision="double",
            steps=STEPS,
        )
        found[frame], previous = hair, hair.state
    return tuple(
        Frames(NUMBERS, {f: getattr(h, name) for f, h in found.items()}.__getitem__) for name in ("state", "strands")
    )


def restarted(shot, groom=GROOM, **settings):
    settings = {"model": "network", "precision": "double", "steps": STEPS, "restarts": 3, **settings}
    return restart_hair(groom, None, None, None, None, *shot, Time(1, FPS), (), **settings)


def test_the_reference_continues_to_the_bit_as_it_went(shot):
    summary, windows = restarted(shot, window=3)
    assert windows["frame"].tolist() == [1, 2, 3]
    assert not any(np.any(numbers) for numbers in summary.numbers.values())
    assert not windows["after the window [% of length]"].any()


def test_errors_are_in_proportion_to_what_is_wrong(shot):
    one, two = (restarted(shot, gravity=9.81 * (1.0 + wrong), window=3).windows for wrong in (1e-4, 2e-4))
    for after in ("after 1 frame [% of length]", "after the window [% of length]"):
        assert two[after] / one[after] == pytest.approx(np.full(3, 2.0), rel=1e-2)


def test_the_summary_is_of_squares_over_the_restarts(shot):
    summary, windows = restarted(shot, gravity=11.0)
    errors = windows["after 1 frame [% of length]"]
    values = [summary[f"restart {name} [% of length]"][0] for name in ("error", "low", "high", "median")]
    reach = 2.9199856 * np.std(errors**2, ddof=1) / np.sqrt(3)  # t of 2 degrees of freedom, 95 %
    square = np.mean(errors**2)
    expected = np.sqrt(np.maximum([square, square - reach, square + reach], 0.0))
    assert values == pytest.approx([*expected, np.median(errors)])


def test_hair_that_is_not_finite_is_infinitely_wrong(shot):
    summary, windows = restarted(shot, gravity=1e300, window=2)
    assert np.isinf(windows["after 1 frame [% of length]"]).all() and np.isinf(
        summary["restart error [% of length]"][0]
    )


def test_restarts_are_spread_over_the_shot_and_have_room_for_their_window():
    assert restart_frames(list(range(1001, 1038)), 7, 4) == [1005, 1009, 1013, 1017, 1021, 1025, 1029]
    assert restart_frames([5, 6], 7, 1) == [5]
    with pytest.raises(BadInput, match="2 frames"):
        restart_frames([5, 6], 7, 2)
    with pytest.raises(BadInput, match="frames are missing"):
        restart_frames([5, 7], 1, 1)


def test_other_segments_other_hairs_and_other_models_are_refused(shot):
    finer = lay_strands(9, 0.05, 8, (1.0, -0.3, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    fewer = lay_strands(8, 0.05, 4, (1.0, -0.3, 0.0), (0.0, 0.0, 0.01), None, 0.0)
    for groom, settings in ((finer, {}), (fewer, {}), (GROOM, {"model": "chain"})):
        with pytest.raises(BadInput, match="of other strands, segments or springs"):
            restarted(shot, groom, **settings)
