"""Scattering of light by one hair, in tables: the lobes R, TT and TRT of Marschner et al. 2003.

A hair sends sum_p M_p(theta_i, theta_o) N_p(theta_d, phi) of the light from one direction into another. M_p is the
normalised lobe of d'Eon et al. 2011, Eq. 7; it is found where it is needed. N_p = 1/2 int A_p(h) G(phi - Phi_p(h)) dh
over the offsets h across the hair, with their Gaussian G, Fresnel's share A_0 = F, and A_p = (1-F)^2 F^(p-1) T^p. What
is reflected inside more than once is spread evenly, so that hair that absorbs nothing loses nothing. Widths by the
roughness are those of Chiang et al. 2016.

Absorption is found from a colour, by bisection: that of hair so deep that no light comes through, shaded as `dual.py`
does it. a_f and a_b are what a hair sends on and back of light from half the azimuths, as in Zinke et al. 2008.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

ROUGHNESS = 0.3
"""Of hair, along it and around it."""
COLOURS, STEPS, ACROSS = 24, 32, 64
"""Colours of a table, its inclinations, its azimuths of half a turn, and offsets across a hair."""
STEP = np.pi / (STEPS - 1)
"""From one azimuth to the next [rad]."""
AZIMUTHS = np.arange(2 * STEPS - 2) * STEP
"""Of a whole turn, from that of the lamp [rad]."""
OFFSETS = (np.arange(ACROSS) + 0.5) * 2.0 / ACROSS - 1.0
"""Of light across a hair, over its radius, (ACROSS,)."""
FRONT = np.cos(AZIMUTHS) > 0.0
"""Those on the side of the lamp."""
INDEX = 1.55
"""Of refraction."""
WIDTH = (0.726 * ROUGHNESS + 0.812 * ROUGHNESS**2) ** 2
"""Variance of the lobe R along the hair (Chiang et al. 2016, Eq. 7) [rad^2]."""
WIDTHS = WIDTH, WIDTH / 4, WIDTH * 4
"""Variances of the lobes R, TT, and TRT with all that follow, along the hair [rad^2]."""
TILTS = 2.0, -1.0, -3.0
"""Angles by which R, TT, and TRT with all that follow are turned to the root, over the tilt of the scales."""
TURN = (0.265 * ROUGHNESS + 1.194 * ROUGHNESS**2) * np.sqrt(np.pi / 8) * np.pi / np.sqrt(3)
"""Deviation of G: that of the logistic lobe of Chiang et al. 2016, Eq. 8 [rad]."""
BLACKEST = 50.0
"""The most that is absorbed over the radius of a hair: nothing comes through."""

EUMELANIN, PHEOMELANIN = np.array([0.506, 0.841, 1.653]), np.array([0.343, 0.733, 1.924])
"""Absorption of red, green and blue by one unit of each over the radius of a hair (d'Eon et al. 2011)."""
LEAST = 1e-4
"""Light that the blackest hair lets through."""


class Scattering(NamedTuple):
    """Scattering of a hair by square root of a colour, sine of an inclination, and azimuth, evenly spaced.

    lobes    N of R, TT, and TRT with all that follow, and of the sum, averaged over light from half the azimuths; by
             |sin theta_d| and phi in 0..pi, 0 where the eye is at the lamp, (COLOURS, STEPS, STEPS, 4) float32
    streams  a_f and a_b; by |sin theta_d|, (COLOURS, STEPS, 2) float64
    events   variances that a crossing and a return add along the hair [rad^2], and angles by which they turn light to
             the root, over the tilt of its scales; by |sin theta_d|, (COLOURS, STEPS, 4) float64
    """

    lobes: np.ndarray
    streams: np.ndarray
    events: np.ndarray


@lru_cache(maxsize=1)
def tabulate() -> Scattering:
    """Build the tables, of all colours at once; pure."""
    entry, turned, averaged = refract(), *gaussians()
    sent = shares(entry, absorptions())
    lobes = np.einsum("cpth,pthn->ctnp", sent, turned[..., :STEPS])  # no BLAS: it may add in another order
    lobes[..., 2] += lobes[..., 3]
    lobes[..., 3] = combine(sent, averaged[..., :STEPS])
    back, total = ((sent * part.sum(axis=-1)).sum(axis=3) * STEP for part in (averaged[..., FRONT], turned))
    parts = total - back, back
    a_f, a_b = (part.sum(axis=1) for part in parts)
    events = [
        np.einsum("cpt,p->ct", part, each) / share
        for each in ([*WIDTHS, WIDTHS[2]], [*TILTS, TILTS[2]])
        for part, share in zip(parts, (a_f, a_b), strict=True)
    ]
    return Scattering(lobes.astype(np.float32), np.stack([a_f, a_b], axis=-1), np.stack(events, axis=-1))


@lru_cache(maxsize=1)
def absorptions() -> np.ndarray:
    """Find what hair absorbs over its radius, for the colours of a table, (COLOURS,)."""
    entry, turned, averaged = refract(), *gaussians()
    colours = np.linspace(0.0, 1.0, COLOURS) ** 2
    low = np.zeros(COLOURS)
    high = np.full(COLOURS, BLACKEST)
    for _ in range(50):
        middle = 0.5 * (low + high)
        sent = shares(entry, middle)[:, :, :1]
        brighter = deep_colour(combine(sent, turned[:, :1]), combine(sent, averaged[:, :1]))[:, 0] > colours
        low, high = np.where(brighter, middle, low), np.where(brighter, high, middle)
    return np.where(colours < 1.0, high, 0.0)


def absorption_of(colours: np.ndarray) -> np.ndarray:
    """Look up what hair absorbs over its radius that in deep locks has such colours, linear, of any shape; pure."""
    return np.interp(np.sqrt(colours), np.linspace(0.0, 1.0, COLOURS), np.sqrt(absorptions())) ** 2


def colour_of(absorbed: np.ndarray) -> np.ndarray:
    """Look up the linear colours of deep locks of hair that absorbs so much over its radius, of any shape; pure."""
    return np.interp(np.sqrt(absorbed), np.sqrt(absorptions())[::-1], np.linspace(1.0, 0.0, COLOURS)) ** 2


def pigment_colour(melanin: float, redness: float) -> np.ndarray:
    """Return the colour of deep hair by its melanin, 0 white to 1 black, and the share that is red pheomelanin; pure.

    Melanin m is -ln(1 - m) units of pigment, as in Blender, so that m goes evenly from white to black.
    """
    units = -np.log(max(1.0 - melanin, LEAST))
    return colour_of(units * ((1.0 - redness) * EUMELANIN + redness * PHEOMELANIN))


def combine(sent: np.ndarray, spread: np.ndarray) -> np.ndarray:
    return np.einsum("cpth,pthn->ctn", sent, spread)


def deep_colour(sharp: np.ndarray, averaged: np.ndarray) -> np.ndarray:
    """Return the colour of deep hair in light from everywhere, seen from straight above, (n, inclinations).

    It takes N summed over the lobes, of a lamp and averaged, (n, inclinations, azimuths) each. A hair is seen at the
    depth s with the density exp(-s), where a lamp at the azimuth phi has s/cos(phi) hairs before it: of its own light
    cos/(1 + cos) comes there, of the stream D cos/(k + cos).
    """
    cosine = np.cos(AZIMUTHS[FRONT])
    back = STEP * averaged[..., FRONT].sum(axis=-1)
    lost = 1.0 - STEP * averaged[..., ~FRONT].sum(axis=-1)
    k = np.sqrt(np.maximum(lost**2 - back**2, 0.0))
    up = (back / (lost + k))[..., None]
    direct = cosine / (1.0 + cosine)
    down = cosine / (k[..., None] + cosine)
    behind = np.roll(averaged, STEPS - 1, axis=-1)[..., FRONT]
    sent = direct * sharp[..., FRONT] + (down - direct) * averaged[..., FRONT] + up * down * behind
    return STEP * sent.sum(axis=-1)


def bent() -> tuple[np.ndarray, np.ndarray]:
    """Return sines of theta_d, and indices of refraction as seen across the hair (Marschner et al. 2003)."""
    sines = np.linspace(0.0, 1.0, STEPS)
    sines[-1] = 1.0 - 1e-4
    return sines, np.sqrt((INDEX**2 - sines**2) / (1.0 - sines**2))


def refract() -> tuple[np.ndarray, np.ndarray]:
    """Return Fresnel's share of reflected light, and the way inside the hair over its radius, (STEPS, ACROSS) each."""
    sines, index = bent()
    h = OFFSETS
    cosine = np.sqrt((1.0 - sines**2)[:, None] * (1.0 - h**2))
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / INDEX**2)
    parallel = (INDEX * cosine - inside) / (INDEX * cosine + inside)
    across = (cosine - INDEX * inside) / (cosine + INDEX * inside)
    way = 2.0 * np.sqrt(1.0 - (h / index[:, None]) ** 2) / np.sqrt(1.0 - (sines / INDEX) ** 2)[:, None]
    return 0.5 * (parallel**2 + across**2), way


def shares(entry: tuple[np.ndarray, np.ndarray], absorbed: np.ndarray) -> np.ndarray:
    """Return the shares A of R, TT, TRT and the rest, by absorption over a radius (n,), (n, 4, STEPS, ACROSS)."""
    mirrored, way = entry
    through = np.exp(-absorbed[:, None, None] * way)
    once = (1.0 - mirrored) ** 2 * through
    twice = once * mirrored * through
    rest = twice * mirrored * through / (1.0 - mirrored * through)
    return np.stack([np.broadcast_to(mirrored, once.shape), once, twice, rest], axis=1)


def gaussians() -> tuple[np.ndarray, np.ndarray]:
    """Return where R, TT, TRT and the rest leave the hair, over all azimuths, (4, STEPS, ACROSS, 2 STEPS - 2).

    That is of a lamp, and averaged over light from half the azimuths. Sums over the azimuths, times their step, are
    1/ACROSS. Light leaves at 2 p gamma_t - 2 gamma_i + p pi.
    """
    index = bent()[1]
    h = OFFSETS
    outside = np.arcsin(h)
    inside = np.arcsin(h / index[:, None])
    spread = np.full((4, STEPS, ACROSS, len(AZIMUTHS)), 0.5 / np.pi)
    for p in range(3):
        away = AZIMUTHS - (p * (2.0 * inside + np.pi) - 2.0 * outside)[..., None]
        away -= 2.0 * np.pi * np.round(away / (2.0 * np.pi))
        spread[p] = np.exp(-0.5 * (away / TURN) ** 2)
    spread /= ACROSS * spread.sum(axis=-1, keepdims=True) * STEP
    averaged = [spread[..., np.roll(FRONT, at)].mean(axis=-1) for at in range(len(FRONT))]
    return spread, np.stack(averaged, axis=-1)
