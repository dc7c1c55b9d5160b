"""What is seen of hair, where the answer is known."""

import numpy as np
import pytest

from hairpipe.measure import climate
from hairpipe.measure.contact import nearest
from hairpipe.values import Strands

LENGTH, SPACING = 0.2, 0.004


def lattice(side=10, segments=8, shift=(0.0, 0.0, 0.0), speed=0.0, stretch=1.0):
    """Straight strands that hang from a square lattice, moving along x as stiff pendulums do: speed at the tip."""
    grid = SPACING * np.stack(np.meshgrid(*[np.arange(side)] * 2, [0.0]), axis=-1).reshape(-1, 1, 3)[:, :, [0, 2, 1]]
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
    assert nearest(climate.places(lattice())) == pytest.approx(np.full(5, SPACING))


def test_points_touch_their_four_neighbours_in_a_lattice_and_not_their_own_strand():
    side = 10
    inside = 4 * side * (side - 1) / side**2
    assert climate.contacts(lattice(side), 1.1 * SPACING) == pytest.approx(inside)
    assert climate.contacts(lattice(side), 0.9 * SPACING) == 0.0
    assert climate.contacts(lattice(1, segments=100), 1.1 * SPACING) == 0.0


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
