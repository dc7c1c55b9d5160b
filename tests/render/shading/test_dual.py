"""Light that hair scatters: white hair loses none, deep hair has its colour; one hair is compared with rays."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, trapezoid
from scipy.special import i0e

from hairpipe.render.dual_scattering import (
    AZIMUTHS,
    COLOURS,
    INDEX,
    STEP,
    STEPS,
    TURN,
    absorption_of,
    add_scattered,
    bessel,
    cone,
    count_events,
    pigment_colour,
    refract,
    shares,
    streams,
    tabulate,
)
from hairpipe.render.kajiya_kay import Fibres
from hairpipe.render.lights import Light
from hairpipe.render.skin import IRRADIANCE


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


LAMP = np.pi / 12 / IRRADIANCE
"""Between azimuths, and light of a lamp that fills 1."""
AROUND = (np.arange(24) + 0.5) * np.pi / 12
SINES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def furnace(colour: tuple[float, float, float], thick: float, slope: float = 0.0) -> np.ndarray:
    """What a slab of hairs along y sends to a far eye in light 1 from everywhere, (3,).

    The eye looks at it from above, at a slope along the hairs [rad], and sees one at the depth t with the density
    exp(-t); in the way of light from an azimuth about the hairs are more, by one over its cosine.
    """
    deep = np.arange(0.0, min(thick, 12.0), 0.05) + 0.025
    seen, along = np.zeros((len(deep), 3)), np.tile([0.0, 1.0, 0.0], (len(deep), 1))
    hair = Fibres(np.zeros_like(seen), along, np.zeros_like(seen), np.tile(colour, (len(deep), 1)), np.zeros(len(deep)))
    eye = 1e6 * np.array([0.0, np.sin(slope), np.cos(slope)])
    for sine, weight in zip(SINES, WEIGHTS, strict=True):
        for azimuth in AROUND:
            cosine, across = np.cos(azimuth), np.sqrt(1.0 - sine**2)
            light = Light(np.array([across * np.sin(azimuth), sine, across * cosine]), np.full(3, weight * LAMP))
            before = (deep if cosine > 0 else thick - deep) / abs(cosine)
            met = np.stack([before, np.full(len(deep), thick / abs(cosine))], axis=1)
            add_scattered(seen, hair, np.array(colour), eye, light, met, tabulate())
    return 0.05 * np.exp(-deep) @ seen / (1.0 - np.exp(-thick))


@pytest.mark.parametrize("slope", [0.0, 0.5])
def test_deep_white_hair_is_white_in_a_furnace(slope: float) -> None:
    assert 0.9 < furnace((1.0, 1.0, 1.0), 60.0, slope)[0] <= 1.0


def test_thin_white_hair_neither_loses_much_light_nor_makes_any_of_note() -> None:
    """More than 1 is due to the sharp lobes, which are seen where light comes a short way."""
    assert all(0.95 < furnace((1.0, 1.0, 1.0), thick)[0] < 1.15 for thick in (0.2, 1.0, 3.0))


@pytest.mark.parametrize("slope", [0.0, 0.5])
@pytest.mark.parametrize(
    "colour",
    [(0.112, 0.051, 0.024), (0.604, 0.38, 0.171), (0.03, 0.03, 0.03), (0.9, 0.85, 0.8)],
    ids=["brown", "blond", "black", "white"],
)
def test_deep_hair_has_the_colour_that_was_requested(colour: tuple[float, float, float], slope: float) -> None:
    assert furnace(colour, 60.0, slope) == pytest.approx(np.array(colour), rel=0.1)


@pytest.mark.parametrize(("on", "back", "last"), [(0.6, 0.3, 5.0), (0.781, 0.219, 3.0), (0.1, 0.05, 20.0)])
def test_streams_solve_their_equations(on: float, back: float, last: float) -> None:
    def slopes(_, flow):
        return np.stack([-(1.0 - on) * flow[0] + back * flow[1], (1.0 - on) * flow[1] - back * flow[0]])

    depths = np.linspace(0.0, last, 41)
    exact = solve_bvp(slopes, lambda first, end: [first[0] - 1.0, end[1]], depths, np.ones((2, 41)), tol=1e-8)
    found = np.array([streams(on, back, n, last) for n in depths]).T
    assert found == pytest.approx(exact.sol(depths), abs=1e-3)


def test_events_are_those_that_photons_have_behind_them() -> None:
    """Photons walk through hair one event after another, as far as the exponential distribution says."""
    on, back, last, n = 0.55, 0.3, 6.0, 2.0
    rng, count = np.random.default_rng(5), 100_000
    at, way, crossed, returned = np.zeros(count), np.ones(count), np.zeros(count), np.zeros(count)
    seen: list[list[tuple[float, float]]] = [[], []]
    while len(at):
        ahead = at + way * rng.exponential(size=len(at))
        passed = (at - n) * (ahead - n) < 0.0
        for stream, towards in zip(seen, (way > 0.0, way < 0.0), strict=True):
            stream += [*zip(crossed[passed & towards], returned[passed & towards], strict=True)]
        fate = rng.random(len(at))
        stays = (ahead > 0.0) & (ahead < last) & (fate < on + back)
        turns = fate > on
        at, way = ahead[stays], np.where(turns, -way, way)[stays]
        crossed, returned = (crossed + ~turns)[stays], (returned + turns)[stays]
    down, up = (np.array(stream) for stream in seen)
    down = down[down.sum(axis=1) > 0.0]
    found = np.array(count_events(on, back, n, last)).T
    assert found == pytest.approx(np.array([down.mean(axis=0), up.mean(axis=0)]), rel=0.03, abs=0.02)


def test_scales_turn_a_cone_to_the_root() -> None:
    angles = np.linspace(-1.5, 1.5, 3001)
    lobe = [cone(0.0, 1.0, np.sin(a), np.cos(a), 0.2, 0.02) for a in angles]
    assert angles[np.argmax(lobe)] == pytest.approx(-0.2, abs=1e-3)


@pytest.mark.parametrize("width", [0.02, 0.1, 0.5, 5.0])
def test_a_cone_holds_all_light_and_is_the_same_both_ways(width: float) -> None:
    angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2001)
    sines, cosines = np.sin(angles), np.cos(angles)
    for lamp in (0.0, 0.7, 1.4):
        sine, cosine = np.sin(lamp), np.cos(lamp)
        lobe = [cone(sine, cosine, s, c, 0.0, width) for s, c in zip(sines, cosines, strict=True)]
        assert trapezoid(lobe * cosines, angles) == pytest.approx(1.0, abs=1e-4)
        assert lobe[300] == pytest.approx(cone(sines[300], cosines[300], sine, cosine, 0.0, width))


def test_bessel_function() -> None:
    x = np.linspace(0.0, 80.0, 400)
    assert [bessel(at) for at in x] == pytest.approx(i0e(x), rel=1e-6)
