"""The lattice of a level set, and what is read of it at a point."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator

from hairpipe.errors import BadInput
from hairpipe.levelset.grid_layout import lattice_around
from hairpipe.levelset.sample import distance, field_of, gradient, sample, velocity
from hairpipe.values import LevelSet
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


VOXEL = 0.25
ORIGIN = np.array([-2.0, 4.0, 0.0])
SLOPE, SHIFT = np.array([0.3, -0.5, 0.2]), 1.3
SPREAD, DRIFT = np.array([[1.0, 2, 3], [0, -1, 1], [0.5, 0, 2]]), np.array([0.1, 0.2, 0.3])
within = st.tuples(st.floats(-2, 1.999), st.floats(4, 7.999), st.floats(0, 1.999))


def make(values, vectors) -> LevelSet:
    """2 x 2 x 1 bricks: three filled by functions of position, and one far inside."""
    bricks = np.array([[[2], [0]], [[1], [LevelSet.FAR_INSIDE]]], np.int32)
    places = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])
    inside = np.stack(np.meshgrid(*[np.arange(9)] * 3, indexing="ij"), axis=-1)
    points = ORIGIN + VOXEL * (8 * places[:, None, None, None] + inside)
    corners = ORIGIN + VOXEL * 8 * np.stack(np.meshgrid(*map(np.arange, (3, 3, 2)), indexing="ij"), axis=-1)
    inner = np.concatenate([(corners @ SLOPE + SHIFT)[..., None], corners @ SPREAD.T + DRIFT], axis=-1)
    arrays = (bricks, values(points), vectors(points), inner)
    return LevelSet(*(a if a is bricks else a.astype(np.float32) for a in arrays), ORIGIN, VOXEL, 16.0)


@pytest.fixture(scope="module")
def slope():
    return field_of(make(lambda x: x @ SLOPE + SHIFT, lambda x: x @ SPREAD.T + DRIFT))


@settings(deadline=None)
@given(within)
def test_a_linear_field_is_read_exactly_in_every_brick_and_far_inside(slope, point):
    x = np.array(point)
    phi, *g = sample(slope, *point)
    assert phi == pytest.approx(x @ SLOPE + SHIFT, abs=1e-6)
    assert distance(slope, *point) == phi
    if not (x[0] > -1e-9 and x[1] > 6 - 1e-9):  # far inside
        assert g == pytest.approx(SLOPE, abs=1e-5)
    assert velocity(slope, *point) == pytest.approx(SPREAD @ x + DRIFT, abs=1e-5)


def test_noise_is_read_as_scipy_reads_it():
    noise = np.random.default_rng(1).normal(size=(3, 9, 9, 9)).astype(np.float32)
    surface = make(lambda x: noise, lambda x: np.repeat(noise[..., None], 3, axis=-1))
    axes = [start + VOXEL * np.arange(9) for start in (-2.0, 6.0, 0.0)]
    exact = RegularGridInterpolator(axes, noise[0].astype(float))
    points = np.random.default_rng(2).uniform([-2, 6, 0], [0, 8, 2], (200, 3))
    field = field_of(surface)
    assert [distance(field, *point) for point in points] == pytest.approx(exact(points), abs=1e-6)
    assert [velocity(field, *point)[1] for point in points] == pytest.approx(exact(points), abs=1e-6)


def test_the_gradient_is_that_of_the_interpolant():
    surface = make(lambda x: np.sin(x).prod(axis=-1), lambda x: x)
    field, e = field_of(surface), 1e-5
    for point in np.random.default_rng(2).uniform([-2, 4, 0], [0, 6, 2], (50, 3)):
        if (np.abs((point - ORIGIN) / VOXEL % 1 - 0.5) > 0.49).any():
            continue
        differences = [(distance(field, *point + e * n) - distance(field, *point - e * n)) / (2 * e) for n in np.eye(3)]
        assert sample(field, *point)[1:] == pytest.approx(differences, abs=1e-6)


def test_outside_the_bricks_is_the_border_of_the_band(slope):
    points = ((-2.01, 5, 1), (2, 5, 1), (0, 3.9, 1), (0, 8.01, 1), (0, 5, -1e-9), (0, 5, 2), (1e30, 0, 0))
    for point in np.array(points, float):
        assert sample(slope, *point) == (4.0, 0, 0, 0)
        assert velocity(slope, *point) == (0, 0, 0)


def test_nan_point_is_outside(slope):
    assert sample(slope, np.nan, 5.0, 1.0) == (4.0, 0, 0, 0)


def test_the_smooth_gradient_is_closer_to_the_body_than_the_interpolants(sphere):
    from hairpipe.levelset.bake import bake

    field = field_of(bake(sphere(level=5), 0.08, 4.0))
    points = np.random.default_rng(0).normal(size=(500, 3))
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    smooth = np.array([gradient(field, *point) for point in normals * 1.02])
    rough = np.array([sample(field, *point)[1:] for point in normals * 1.02])
    smooth, rough = (
        np.degrees(np.arccos(np.clip((g * normals).sum(axis=1) / np.linalg.norm(g, axis=1), -1, 1)))
        for g in (smooth, rough)
    )
    assert smooth.max() < 1.0 < rough.max()
    assert smooth.mean() < 0.4 * rough.mean()
