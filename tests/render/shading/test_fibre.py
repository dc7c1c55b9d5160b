"""One hair, compared with rays that are traced through a circle of glass."""

import numpy as np
import pytest

from hairpipe.render.dual_scattering import (
    AZIMUTHS,
    COLOURS,
    INDEX,
    STEP,
    STEPS,
    TURN,
    absorption_of,
    pigment_colour,
    refract,
    shares,
    tabulate,
)


def refracted(way: np.ndarray, normal: np.ndarray, ratio: float) -> np.ndarray:
    """Direction behind a surface that faces a ray (Snell), both units; ratio of the indices before and behind."""
    cosine = -way @ normal
    return ratio * way + (ratio * cosine - np.sqrt(1.0 - ratio**2 * (1.0 - cosine**2))) * normal


def reflectance(way: np.ndarray, onward: np.ndarray, normal: np.ndarray, before: float, behind: float) -> float:
    """Share of light that is reflected, unpolarised, by Fresnel's amplitudes of fields."""
    one, two = -way @ normal, -onward @ normal
    across = (before * one - behind * two) / (before * one + behind * two)
    within = (before * two - behind * one) / (before * two + behind * one)
    return 0.5 * (across**2 + within**2)


def trace(h: float, absorbed: float) -> list[tuple[float, float]]:
    """Azimuth and share of R, TT and TRT of a ray along -x that meets a circle of glass at the height h."""
    at, way, left = np.array([np.sqrt(1.0 - h * h), h]), np.array([-1.0, 0.0]), []
    inside = refracted(way, at, 1.0 / INDEX)
    mirrored = reflectance(way, inside, at, 1.0, INDEX)
    leaves, share = way - 2.0 * (way @ at) * at, 1.0 - mirrored
    left.append((float(np.arctan2(leaves[1], leaves[0])), mirrored))
    for _ in range(2):
        chord = -2.0 * (inside @ at)
        at, share = at + chord * inside, share * np.exp(-absorbed * chord)
        leaves = refracted(inside, -at, INDEX)
        mirrored = reflectance(inside, leaves, -at, INDEX, 1.0)
        left.append((float(np.arctan2(leaves[1], leaves[0])), share * (1.0 - mirrored)))
        inside, share = inside - 2.0 * (inside @ at) * at, share * mirrored
    return left


def test_lobes_are_where_rays_through_a_circle_leave_it() -> None:
    offsets = (np.arange(400) + 0.5) / 200 - 1.0
    rays = np.array([trace(h, 0.0) for h in offsets])
    away = AZIMUTHS[:STEPS, None, None] - rays[..., 0]
    away -= 2.0 * np.pi * np.round(away / (2.0 * np.pi))
    blurred = np.exp(-0.5 * (away / TURN) ** 2) / (TURN * np.sqrt(2.0 * np.pi))
    expected = np.mean(rays[..., 1] * blurred, axis=1)
    expected[:, 2] += (1.0 - rays[..., 1].sum(axis=1)).mean() / (2.0 * np.pi)
    found = tabulate().lobes[-1, 0, :, :3]  # white hair
    assert found == pytest.approx(expected, abs=0.01 * expected.max())


def test_absorbed_is_what_lies_along_the_way_inside() -> None:
    through = shares(refract(), np.array([0.7]))[0, :3, 0]
    h = (np.arange(through.shape[1]) + 0.5) * 2.0 / through.shape[1] - 1.0
    assert through == pytest.approx(np.array([[share for _, share in trace(at, 0.7)] for at in h]).T, rel=1e-9)


def test_white_hair_sends_on_or_back_all_that_comes_and_darker_hair_less() -> None:
    on, back = np.moveaxis(tabulate().streams[..., :2], -1, 0)
    assert on[-1] + back[-1] == pytest.approx(np.ones(STEPS))
    assert (np.diff(on + back, axis=0) > -1e-12).all() and (on + back)[COLOURS // 2].max() < 1.0


def test_averaging_over_azimuths_keeps_the_light() -> None:
    lobes = tabulate().lobes[:, 0].astype(float)
    sums = 2.0 * STEP * (lobes.sum(axis=1) - 0.5 * (lobes[:, 0] + lobes[:, -1]))
    assert sums[:, :3].sum(axis=1) == pytest.approx(sums[:, 3], rel=1e-5)


def deep_by_surface() -> float:
    """Light that deep hair gives back from everywhere by the mirroring of its surface alone (Kubelka and Munk 1931)."""
    outside = np.arcsin(np.linspace(-1.0, 1.0, 4001)[1:-1])
    inside = np.arcsin(np.sin(outside) / INDEX)
    across, along = np.cos(outside) / np.cos(inside), np.cos(inside) / np.cos(outside)
    mirrored = 0.5 * (((across - INDEX) / (across + INDEX)) ** 2 + ((along - INDEX) / (along + INDEX)) ** 2)
    lamps = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 721)[:, None]
    back = (mirrored * (np.cos(lamps - 2.0 * outside) > 0.0)).mean()
    lost = 1.0 - (mirrored.mean() - back)
    return (lost - np.sqrt(lost**2 - back**2)) / back


def test_pigment_darkens_from_white_to_black_blue_first() -> None:
    shades = np.array([pigment_colour(melanin, 0.5) for melanin in (0.0, 0.3, 0.6, 0.9, 1.0)])
    assert np.array_equal(shades[0], [1.0, 1.0, 1.0]) and np.all(np.diff(shades, axis=0) < 0)
    assert shades[-1].max() < deep_by_surface()
    assert np.all(np.diff(shades[1:], axis=1) < 0)
    red, brown = pigment_colour(0.5, 1.0), pigment_colour(0.5, 0.0)
    assert red[0] / red[2] > brown[0] / brown[2]


def test_absorption_is_found_again_from_the_colour() -> None:
    """As Blender says: melanin m is -ln(1 - m) units."""
    assert absorption_of(pigment_colour(0.6, 0.0)) == pytest.approx(-np.log(0.4) * np.array([0.506, 0.841, 1.653]))
