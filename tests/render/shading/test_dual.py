"""Light that hair scatters: none is lost in white hair, and deep hair has the colour that was asked for."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, trapezoid
from scipy.special import i0e

from hairpipe.render.dual_scattering import add_scattered, bessel, cone, count_events, streams, tabulate
from hairpipe.render.kajiya_kay import Fibres
from hairpipe.render.lights import Light
from hairpipe.render.skin import IRRADIANCE

TURN = np.pi / 12 / IRRADIANCE
"""Between azimuths, and light of a lamp that fills 1."""
AZIMUTHS = (np.arange(24) + 0.5) * np.pi / 12
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
        for azimuth in AZIMUTHS:
            cosine, across = np.cos(azimuth), np.sqrt(1.0 - sine**2)
            light = Light(np.array([across * np.sin(azimuth), sine, across * cosine]), np.full(3, weight * TURN))
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
