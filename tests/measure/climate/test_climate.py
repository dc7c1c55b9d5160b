"""Errors of hair that is chaotic, of synthetic members with known answers."""

import numpy as np
import pytest

from hairpipe.engine import Reached, Time
from hairpipe.errors import BadInput
from hairpipe.measure import climate
from hairpipe.measure.climate import LOOKS
from hairpipe.measure.contact import nearest
from hairpipe.nodes.measure_climate import measure_climate
from hairpipe.values import Strands

LENGTH, SEGMENTS, SIDE, COUNT, FPS, SPACING = 0.2, 4, 6, 13, 24.0, 0.01
ROOTS = SPACING * np.stack(
    [np.repeat(np.arange(SIDE), SIDE), np.zeros(SIDE**2), np.tile(np.arange(SIDE), SIDE)], axis=1
)
CALM, WILD = 0.02e-2 * LENGTH, 5e-2 * LENGTH
MEMBERS, TRUTH = (0, 5, 6), (0, 1, 2, 3, 4)
ERROR, BIAS = "error [% of length]", "bias [% of length]"


def run(seed, model=0, shift=0.0, liveliness=1.0, segments=SEGMENTS, wild_from=7, reached=COUNT):
    """Strands that hang and tremble, alike for equal seeds, and from a frame on go far, each run its own way.

    shift       of all points but roots along x, after the first frame
    liveliness  factor of velocities
    """
    calm, wild = np.random.default_rng([1, seed]), np.random.default_rng([2, seed, model])
    shares, frames = np.linspace(0.0, 1.0, segments + 1)[:, None], {}
    for frame in range(1, COUNT + 1):
        stream, size = (wild, WILD) if frame >= wild_from else (calm, CALM)
        swing = size * stream.standard_normal((SIDE**2, 1, 3))
        points = ROOTS[:, None] + shares * (np.array([0.0, -LENGTH, 0.0]) + swing)
        points[:, 1:, 0] += shift * (frame > 1)
        velocities = (liveliness * FPS * shares * swing).reshape(-1, 3).astype(np.float32)
        offsets = np.arange(0, len(velocities) + 1, segments + 1).astype(np.int32)
        frames[frame] = Strands(points.reshape(-1, 3), velocities, offsets, 8e-5)
    return Reached(tuple(range(1, reached + 1)), frames.__getitem__)


def measured(hair=None, half=None, reference=None, **settings):
    hair = hair or [run(seed, 1) for seed in MEMBERS]
    settings = {"members": MEMBERS, "truth_members": TRUTH, **settings}
    return measure_climate(tuple(hair), tuple(reference or map(run, TRUTH)), half, Time(1, FPS), **settings)


def test_hair_is_predicted_until_the_reference_spreads():
    table = measured()
    assert table["predicted [s]"][0] == 5 / FPS  # frames 2 to 6
    assert table["chaos"][0].startswith("from frame 7 on: two references are at most ")
    assert measured(tolerance=0.5)["chaos"][0].startswith("none: ")


def test_equal_models_do_not_differ_significantly():
    table = measured()
    assert table[ERROR][0] == 0.0  # equal seeds tremble alike
    assert table[BIAS][0] < table["bias floor [% of length]"][0]
    assert table["bias low [% of length]"][0] < 0.0 < table["bias high [% of length]"][0]
    assert table["spread"][0] == pytest.approx(1.0, abs=0.1) and table["p"][0] > 0.1


def test_a_shift_is_seen_at_its_size_early_and_late_though_chaos_is_larger():
    shift = 0.02 * LENGTH
    table = measured([run(seed, 1, shift) for seed in MEMBERS])
    assert table[ERROR][0] == pytest.approx(2.0, rel=2e-3)  # strands that tremble are longer
    assert table[BIAS][0] == pytest.approx(2.0, rel=0.3)
    # points swing by a share of WILD, rms over the shares and axes
    spread = np.sqrt(2.0 * 3.0 * np.mean(np.linspace(0.25, 1.0, 4) ** 2)) * 5.0
    assert table[BIAS][0] + spread > 2.0  # which any one run is off by
    assert table["position T/F"][0] > 1.0 and table["p"][0] < 0.1 and table["Z"][0] > 1.0
    assert table["kinetic energy T/F"][0] < 1.0


def test_too_large_spread_is_refused():
    table = measured([run(seed, 1, liveliness=1.5) for seed in MEMBERS])
    assert table["Z"][0] == max(table["kinetic energy T/F"][0], table["speed spectrum T/F"][0]) > 3.0
    assert table["position T/F"][0] < 1.0 and table[ERROR][0] == 0.0


def test_intervals_are_by_patches_where_there_are_some():
    hair = [run(seed, 1, 0.02 * LENGTH) for seed in MEMBERS]
    one, four = measured(hair), measured(hair, patches=4)
    assert np.isnan(one["low [% of length]"][0])  # of one seed on both sides
    assert 1.99 < four["low [% of length]"][0] < four[ERROR][0] < four["high [% of length]"][0] < 2.01
    assert four["bias low [% of length]"][0] < four[BIAS][0] < four["bias high [% of length]"][0]
    assert four[BIAS][0] == pytest.approx(one[BIAS][0], rel=1e-9)


def test_the_floor_is_what_half_the_step_makes_or_chance():
    tremble = 100.0 * CALM / LENGTH * np.sqrt(2.0 * 3.0 * np.mean(np.linspace(0.25, 1.0, 4) ** 2))
    assert measured()["floor [% of length]"][0] == pytest.approx(tremble, rel=0.05)
    half = measured(half=(run(0, 2, 0.001 * LENGTH), run(1, 2, 0.001 * LENGTH)))
    assert half["floor [% of length]"][0] == pytest.approx(0.1, rel=2e-3)


def test_predictable_hair_has_no_climate():
    calm = {"wild_from": COUNT + 1}
    table = measured([run(s, 1, 0.01 * LENGTH, **calm) for s in MEMBERS], reference=[run(s, **calm) for s in TRUTH])
    assert table["chaos"][0].startswith("none") and table["predicted [s]"][0] == (COUNT - 1) / FPS
    assert (
        table[ERROR][0] == pytest.approx(1.0, rel=2e-3) and np.isnan([table[name][0] for name in (*LOOKS, BIAS)]).all()
    )


def test_hair_in_other_segments_is_compared():
    table = measured([run(seed, 1, segments=7) for seed in MEMBERS])
    assert table[ERROR][0] == pytest.approx(0.0, abs=1e-9) and table["p"][0] > 0.1


def test_a_member_that_is_not_finite_fails_the_model():
    table = measured([run(0, 1), run(5, 1, reached=9), run(6, 1, reached=4)])
    assert table["failed"] == ("member 6 not finite at frame 5",) and np.isinf(table[ERROR][0])


def test_unmatched_hair_is_refused():
    with pytest.raises(BadInput, match="no member is on both sides"):
        measured(members=(5, 6, 7))
    with pytest.raises(BadInput, match="apart at the first frame"):
        measured(tolerance=1e-6)
    with pytest.raises(BadInput, match="as many of each"):
        measured(members=(0, 1))
    with pytest.raises(BadInput, match="in 37 patches"):
        measured(patches=37)


SPACING_OF_ROOTS = 0.004


def lattice(side=10, segments=8, shift=(0.0, 0.0, 0.0), speed=0.0, stretch=1.0):
    """Straight strands that hang from a square lattice, moving along x as stiff pendulums do: speed at the tip."""
    grid = SPACING_OF_ROOTS * np.stack(np.meshgrid(*[np.arange(side)] * 2, [0.0]), -1).reshape(-1, 1, 3)
    grid = grid[:, :, [0, 2, 1]]
    down = np.linspace(0.0, 1.0, segments + 1)[:, None]
    points = grid + stretch * LENGTH * down * [0.0, -1.0, 0.0] + shift
    velocities = np.broadcast_to(speed * down * [1.0, 0.0, 0.0], points.shape).reshape(-1, 3)
    offsets = np.arange(0, len(velocities) + 1, segments + 1).astype(np.int32)
    return Strands(points.reshape(-1, 3), velocities.astype(np.float32), offsets, 8e-5)


def test_a_cloud_that_is_moved_is_as_far_as_it_is_moved():
    one, other = climate.places(lattice()), climate.places(lattice(shift=(0.03, -0.01, 0.02)))
    assert climate.wasserstein(one, other) == pytest.approx((0.03 + 0.01 + 0.02) / 3)
    assert climate.wasserstein(one, one[:, ::-1]) == 0.0  # whoever is where


def test_clouds_of_other_numbers_are_compared():
    one = np.zeros((1, 2, 3))
    assert climate.wasserstein(one, np.array([[[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]]])) == pytest.approx(0.05)


def test_the_nearest_strand_of_a_lattice_is_its_spacing():
    assert nearest(climate.places(lattice())) == pytest.approx(np.full(5, SPACING_OF_ROOTS))


def test_points_touch_their_four_neighbours_in_a_lattice_and_not_their_own_strand():
    side = 10
    inside = 4 * side * (side - 1) / side**2
    assert climate.contacts(lattice(side), 1.1 * SPACING_OF_ROOTS) == pytest.approx(inside)
    assert climate.contacts(lattice(side), 0.9 * SPACING_OF_ROOTS) == 0.0
    assert climate.contacts(lattice(1, segments=100), 1.1 * SPACING_OF_ROOTS) == 0.0


def test_the_energy_of_a_pendulum_is_a_sixth_of_that_of_its_tip():
    fine = lattice(2, segments=200, speed=0.6)
    assert climate.kinetic_energy(fine, 9.81) == pytest.approx(0.6**2 / 6.0 / (9.81 * LENGTH), rel=1e-4)
    assert climate.tip_speeds(fine) == pytest.approx(np.full(4, 0.6))


def test_the_spectrum_of_a_sine_is_at_its_frequency():
    """The power of a sine of amplitude 1 is one half."""
    times = np.arange(48) / 24.0
    speeds = 2.0 + np.sin(2.0 * np.pi * 3.0 * times)[:, None] * [1.0, 2.0]
    spectrum = climate.log_spectrum(speeds, 24.0)
    assert np.argmax(spectrum) == 5 and np.exp(spectrum[5]) == pytest.approx((0.5 + 2.0) / 2)
    assert np.exp(np.delete(spectrum, 5)).max() < 1e-9


def test_strain_is_that_of_all_segments_but_the_worst_twentieth():
    rest = np.full(800, LENGTH / 8)
    assert climate.strain(lattice(stretch=1.02), rest) == pytest.approx(0.02)
    assert climate.strain(lattice(stretch=0.97), rest) == pytest.approx(0.03)
    rest[:39] /= 2.0
    assert climate.strain(lattice(stretch=1.02), rest) == pytest.approx(0.02)


def test_density_is_elsewhere_by_the_share_that_was_moved():
    here = lattice(4, segments=7, shift=(0.002, -0.001, 0.002))
    assert climate.density(here)[1].sum() == pytest.approx(1.0)
    assert climate.density_distance(climate.density(here), climate.density(here)) == 0.0
    gone = climate.density(lattice(4, segments=7, shift=(1.002, -0.001, 0.002)))
    assert climate.density_distance(climate.density(here), gone) == pytest.approx(1.0)
    lower = climate.density(lattice(4, segments=7, shift=(0.002, -0.041, 0.002)))  # by two of ten cells
    assert climate.density_distance(climate.density(here), lower) == pytest.approx(0.2, abs=0.05)  # to one sample


def test_silhouettes_do_not_depend_on_who_is_where_and_are_disjoint_at_most():
    inside = np.full(3, 0.001)  # of a pixel
    here = climate.silhouettes(lattice(shift=inside))
    assert climate.silhouette_distance(here, climate.silhouettes(lattice(segments=16, shift=inside))) == 0.0
    assert climate.silhouette_distance(here, climate.silhouettes(lattice(shift=1.0 + inside))) == 1.0
    lower = climate.silhouettes(lattice(shift=inside - [0.0, LENGTH / 2, 0.0]))
    expected = (2 * np.sqrt(2.0 / 3.0) + 0.0) / 3  # from above nothing has changed
    assert climate.silhouette_distance(here, lower) == pytest.approx(expected, abs=0.01)


def test_hair_in_other_segments_is_the_same_hair():
    fine, coarse = lattice(segments=8, speed=0.3), lattice(segments=5, speed=0.3)
    found = climate.resampled(coarse, fine.offsets)
    assert np.allclose(found.points, fine.points, atol=1e-12) and np.allclose(found.velocities, fine.velocities)
    assert climate.resampled(fine, fine.offsets) is fine
    with pytest.raises(ValueError, match="4 strands against 100"):
        climate.resampled(lattice(2), fine.offsets)
