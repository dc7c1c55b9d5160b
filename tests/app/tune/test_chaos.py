"""What chaos leaves of a tolerance, on members that are made up."""

from itertools import combinations

import numpy as np
import pytest

from hairpipe.app.tune.measured import MODEL, REFERENCE, Tolerance, chaos_of, climate_of, differences, refusal
from hairpipe.measure.climate import LOOKS, TESTED
from hairpipe.measure.deviation import PATCH_COLUMNS
from hairpipe.values.table import table_of_columns, table_of_rows

FRAMES, PATCHES, SIZE, SPREAD, CALM, WILD = range(1, 13), 4, 400, 1e-2, 1e-4, 7
TOLERANCE = Tolerance(2e-3, "m")
GENERATOR = 11


def tables(sides, shift=0.0, wild=WILD, spread=SPREAD):
    """Tables of all pairs of runs: places in many dimensions, which differ by `CALM`, from a frame on by the spread.

    sides  members of each side, those of the first are shifted; spread  of it
    """
    stream, runs = np.random.default_rng(GENERATOR), []
    for side, members in enumerate(sides):
        for _ in members:
            places = stream.standard_normal((len(FRAMES), PATCHES, SIZE)) / np.sqrt(2.0 * SIZE)
            sizes = [CALM if frame < wild else (SPREAD if side else spread) for frame in FRAMES]
            places *= np.array(sizes)[:, None, None]
            runs.append(places + (0.0 if side else shift / np.sqrt(SIZE)))
    found = {}
    for one, other in combinations(range(len(runs)), 2):
        apart = np.linalg.norm(runs[one] - runs[other], axis=2)
        rows = [
            (frame, patch, 6, d, 0.5 * d, 1e3 * d, 500.0 * d, 0)
            for frame, row in zip(FRAMES, apart, strict=True)
            for patch, d in enumerate(row)
        ]
        found[one, other] = table_of_rows(PATCH_COLUMNS, rows)
    return found


def chaos(tolerance=TOLERANCE, **settings):
    return chaos_of(tables([(), REFERENCE], **settings), tolerance, 4e-4, FRAMES, 24.0)


def look(p=0.5, score=0.8, **ratios):
    values = {name: [0.5] for name in LOOKS} | {"Z": [score], "p": [p]}
    return table_of_columns(values | {f"{name.replace('_', ' ')} T/F": [ratio] for name, ratio in ratios.items()})


def test_hair_is_predicted_until_two_references_are_half_the_tolerance_apart():
    found = chaos()
    assert found.chaotic and found.predicted == WILD - 2 and found.frame == WILD - 1
    assert found.seconds == pytest.approx(5 / 24) and found.apart == pytest.approx(SPREAD, rel=0.1)
    percent = chaos(Tolerance(2.0, "%"))
    assert percent.frame == found.frame and percent.apart == pytest.approx(1e3 * found.apart)
    assert chaos(Tolerance(1e-5, "m")).predicted == 0


def test_members_that_do_not_part_are_not_chaotic():
    found = chaos(wild=99)
    assert not found.chaotic and found.frame == FRAMES[-1] and found.floor == 0.0
    assert found.apart == pytest.approx(CALM, rel=0.2)


def test_floor_is_a_share_of_the_distance_of_two_references():
    """Two against two of independent members differ by their spread over root 2, rms, less it on average."""
    found = chaos()
    assert 0.0 <= found.floor < found.apart
    assert refusal(climate_of(tables([MODEL, REFERENCE]), look(), TOLERANCE, found), found, TOLERANCE, 1.0) == ""
    small = Tolerance(found.floor / 2, "m")
    assert "floor" in refusal(climate_of(tables([MODEL, REFERENCE]), look(), small, found), found, small, 1.0)


def test_a_bias_is_found_though_chaos_is_larger():
    biased = climate_of(tables([MODEL, REFERENCE], shift=4e-3), look(), TOLERANCE, chaos())
    assert biased.bias == pytest.approx(4e-3, rel=0.1) and biased.bias < biased.bound < 5e-3
    alike = climate_of(tables([MODEL, REFERENCE]), look(), TOLERANCE, chaos())
    assert alike.bound < TOLERANCE.value and alike.spread == pytest.approx(1.0, rel=0.1)


def test_significant_models_and_small_spreads_are_refused():
    found, runs = chaos(), tables([MODEL, REFERENCE])
    apart = climate_of(runs, look(p=0.05, score=3.4, contacts=3.4, nearest_strand=1.2), TOLERANCE, found)
    assert set(apart.significant) == {"contacts", "nearest strand"} <= set(TESTED)
    assert refusal(apart, found, TOLERANCE, 2.0) == "significantly different in contacts (3.4 times chance)"
    assert refusal(apart, found, TOLERANCE, 4.0) == ""
    chance = climate_of(runs, look(p=0.2, score=1.2, contacts=1.2), TOLERANCE, found)
    assert refusal(chance, found, TOLERANCE, 1.0) == "" and not differences(chance)
    assert refusal(apart, found, TOLERANCE, None) == ""
    assert differences(apart) == ["contacts (3.4 times chance)", "nearest strand (1.2 times chance)"]
    stiff = climate_of(tables([MODEL, REFERENCE], spread=0.5 * SPREAD), look(), TOLERANCE, found)
    assert refusal(stiff, found, TOLERANCE, 1.0).startswith("significantly different in spread (0.5")
    assert refusal(stiff, found, TOLERANCE, None) == ""


def test_few_frames_have_no_observables_but_positions():
    few = climate_of(tables([MODEL, REFERENCE]), look(score=np.nan, p=np.nan), TOLERANCE, chaos())
    assert few.score is None and few.p is None and not few.significant
