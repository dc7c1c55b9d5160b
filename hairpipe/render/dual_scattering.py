"""Scattering of light by one hair, in tables, and shading of hair by dual scattering.

A hair sends sum_p M_p(theta_i, theta_o) N_p(theta_d, phi) of the light from one direction into another, by the lobes R,
TT and TRT of Marschner et al. 2003. M_p is the normalised lobe of d'Eon et al. 2011, Eq. 7; it is found where it is
needed. N_p = 1/2 int A_p(h) G(phi - Phi_p(h)) dh over the offsets h across the hair, with their Gaussian G, Fresnel's
share A_0 = F, and A_p = (1-F)^2 F^(p-1) T^p. What is reflected inside more than once is spread evenly, so that hair
that absorbs nothing loses nothing. Widths by the roughness are those of Chiang et al. 2016. Absorption is found from a
colour, by bisection: that of hair so deep that no light comes through.

A lamp's light goes through hair in two streams, away from the lamp and back, after Zinke, Yuksel, Weber, Keyser 2008.
With a_f and a_b, what a hair sends on and back of light from half the azimuths, n, the hairs between a place and the
lamp, and N, all hairs on that ray, of which the last sends nothing back,

    dD/dn = -(1 - a_f) D + a_b U,  dU/dn = (1 - a_f) U - a_b D,  D(0) = 1,  U(N) = 0.

These are the streams of Schuster 1905, and of Kubelka and Munk 1931. The share exp(-n) of D is the lamp's own light,
scattered by R, TT and TRT. What else comes, D - exp(-n) from the lamp's side and U from the other, is spread over half
of all azimuths, and along the hair by the crossings and returns that it has behind it, on average, see `count_events`:
each adds a variance, and scales turn it on, so that it drifts to root or tip. a_f and a_b are those of hair around,
each of a colour of its own, at theta_d, half the angle between lamp and eye along the hair; the last event is that of
the hair which is seen. Of how many events there are only the mean counts, not the scatter.

We differ from the paper: it counts hairs one by one, D as a_f^n, and for U it sums the light that turns once or three
times in deep hair. n of a map is a mean, hair may be thin, and white hair shall lose nothing.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.render.film import EDGE
from hairpipe.render.kajiya_kay import Fibres, lay_fibres, strand_colours
from hairpipe.render.lights import Light, Shade
from hairpipe.render.skin import IRRADIANCE

ROUGHNESS = 0.3
"""Of hair, along it and around it."""
COLOURS, STEPS, ACROSS = 24, 32, 64
"""Colours of a table, its inclinations, its azimuths of half a turn, and offsets across a hair."""
STEP = np.pi / (STEPS - 1)  # from one azimuth to the next [rad]
AZIMUTHS = np.arange(2 * STEPS - 2) * STEP  # of a whole turn, from that of the lamp [rad]
OFFSETS = (np.arange(ACROSS) + 0.5) * 2.0 / ACROSS - 1.0  # of light across a hair, over its radius, (ACROSS,)
FRONT = np.cos(AZIMUTHS) > 0.0  # those on the side of the lamp
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
BLACKEST = 50.0  # the most that is absorbed over the radius of a hair: nothing comes through

EUMELANIN, PHEOMELANIN = np.array([0.506, 0.841, 1.653]), np.array([0.343, 0.733, 1.924])
"""Absorption of red, green and blue by one unit of each over the radius of a hair (d'Eon et al. 2011)."""
LEAST = 1e-4  # light that the blackest hair lets through


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


R, TT, TRT = WIDTHS
BEYOND = 1e4  # distance from the lamp behind which all hairs of a ray are [cells]
FLAT = 1e-3  # least extinction of the streams over a hair: less makes no difference, and none would divide by 0
FAINT = 1e-4
"""Step of logarithms of a_f and a_b by which events are counted; of less light than its square there are none."""


def shade_dual(
    points: np.ndarray,
    offsets: np.ndarray,
    sites: np.ndarray,
    colour: np.ndarray,
    eye: np.ndarray,
    shadows: Sequence[Shade],
) -> np.ndarray:
    """Light that sites on the strands send to the eye, linear, (n, 3) float64; arguments as of `shade_hair`.

    Surroundings are the edge of the backdrop: in light from everywhere hair has its colour.
    """
    fibres = lay_fibres(points, offsets, sites, colour, None)
    shed = EDGE * fibres.colours
    strands = np.arange(len(offsets) - 1)
    middles = strand_colours(colour, offsets, strands, offsets[:-1] + offsets[1:] - 1)
    around = colour_of(absorption_of(middles).mean(axis=0))
    for shadow in shadows:
        far = fibres.points - BEYOND * shadow.cell * shadow.light.towards
        met = np.stack([shadow.between(at) for at in (fibres.points, far)], axis=1)
        add_scattered(shed, fibres, around, eye, shadow.light, met, tabulate())
    return shed


@njit(cache=True, nogil=True)
def add_scattered(
    shed: np.ndarray,
    fibres: Fibres,
    around: np.ndarray,
    eye: np.ndarray,
    light: Light,
    met: np.ndarray,
    table: Scattering,
) -> None:
    """Add the light of one lamp that points of fibres scatter to the eye, into `shed` (p, 3).

    met  hairs between them and the lamp, and all on that ray, (p, 2)
    """
    points, along, _, colours, tilts = fibres
    lx, ly, lz = light.towards
    for i in range(len(shed)):
        tx, ty, tz = along[i, 0], along[i, 1], along[i, 2]
        ex, ey, ez = eye[0] - points[i, 0], eye[1] - points[i, 1], eye[2] - points[i, 2]
        away = math.sqrt(ex * ex + ey * ey + ez * ez)
        sin_l = tx * lx + ty * ly + tz * lz
        sin_e = (tx * ex + ty * ey + tz * ez) / away
        cos_l, cos_e = math.sqrt(max(0.0, 1.0 - sin_l * sin_l)), math.sqrt(max(0.0, 1.0 - sin_e * sin_e))
        kappa = ((ex * lx + ey * ly + ez * lz) / away - sin_l * sin_e) / max(cos_l * cos_e, 1e-6)
        azimuth = math.acos(min(max(kappa, -1.0), 1.0)) / math.pi  # Rounding may leave -1 to 1.
        apart = math.sqrt(max(0.0, 0.5 - 0.5 * (cos_l * cos_e + sin_l * sin_e)))
        n = met[i, 0]
        last = max(met[i, 0], met[i, 1])
        direct = math.exp(-n)
        tilt = math.asin(tilts[i])
        onward = 1.0 - azimuth
        cone_r = cone(sin_l, cos_l, sin_e, cos_e, tilt * TILTS[0], R)
        cone_tt = cone(sin_l, cos_l, sin_e, cos_e, tilt * TILTS[1], TT)
        cone_trt = cone(sin_l, cos_l, sin_e, cos_e, tilt * TILTS[2], TRT)
        # How far light spreads hardly depends on the colour: green stands for all.
        level = math.sqrt(around[1])
        crossed, returned = count_events(*at_inclination(table.streams, level, apart, 0), n, last)
        wide, turn = at_inclination(table.events, level, apart, 0), at_inclination(table.events, level, apart, 2)
        # The last event of D is a return if the eye is at the lamp, that of U a crossing.
        x, y = crossed[0] + azimuth, returned[0] + onward
        cone_d = cone(sin_l, cos_l, sin_e, cos_e, tilt * (x * turn[0] + y * turn[1]), x * wide[0] + y * wide[1])
        x, y = crossed[1] + onward, returned[1] + azimuth
        cone_u = cone(sin_l, cos_l, sin_e, cos_e, tilt * (x * turn[0] + y * turn[1]), x * wide[0] + y * wide[1])
        for c in range(3):
            level = math.sqrt(colours[i, c])
            others = math.sqrt(around[c])
            on, back = at_inclination(table.streams, others, apart, 0)
            down, up = streams(on, back, n, last)
            r, tt = at_azimuth(table.lobes, level, apart, azimuth, 0)
            trt, spread = at_azimuth(table.lobes, level, apart, azimuth, 2)
            sent = direct * (cone_r * r + cone_tt * tt + cone_trt * trt) + (down - direct) * cone_d * spread
            if up > 0.0:
                sent += up * cone_u * at_azimuth(table.lobes, level, apart, 1.0 - azimuth, 2)[1]
            shed[i, c] += IRRADIANCE * light.colour[c] * sent


@njit(cache=True, nogil=True)
def streams(on: float, back: float, n: float, last: float) -> tuple[float, float]:
    """Return light on its way from the lamp, over what it sheds, behind n of the last hairs, and on its way back."""
    lost = 1.0 - on
    k = max(math.sqrt(max(lost * lost - back * back, 0.0)), FLAT)
    echo = math.exp(-2.0 * k * (last - n))  # Only falling exponentials: sinh and cosh of deep hair would overflow.
    end = math.exp(-2.0 * k * last)
    left = math.exp(-k * n) / (k + lost + (k - lost) * end)
    return left * (k + lost + (k - lost) * echo), left * back * (1.0 - echo)


@njit(cache=True, nogil=True)
def count_events(on: float, back: float, n: float, last: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Count crossings, and returns, that light has behind it on average: D - exp(-n) and U, see above.

    Light of k events, each of which leaves a share of it, is a sum of share^k: its mean k is the derivative of its
    logarithm by that of the share.
    """
    down, up = streams(on, back, n, last)
    low = FAINT * max(down - math.exp(-n), FAINT**2)
    low_up = FAINT * max(up, FAINT**2)
    crossed, crossed_up = streams(on * (1.0 - FAINT), back, n, last)
    returned, returned_up = streams(on, back * (1.0 - FAINT), n, last)
    return ((down - crossed) / low, (up - crossed_up) / low_up), ((down - returned) / low, (up - returned_up) / low_up)


@njit(cache=True, nogil=True)
def cone(sin_l: float, cos_l: float, sin_e: float, cos_e: float, turn: float, width: float) -> float:
    """Light that goes off at an inclination, of that which comes at another, in a lobe of a variance (d'Eon, Eq. 7).

    csch(1/v)/(2 v) exp(-sin sin/v) I_0(cos cos/v), which over all directions is 2 pi; exponents are drawn together. The
    lobe is turned by an angle to the root.
    """
    s = math.sin(turn)
    c = math.cos(turn)
    sine = sin_e * c + cos_e * s
    both = abs(cos_l * (cos_e * c - sin_e * s))
    x = both / width  # exp(-x) I_0(x) in one: each factor alone would overflow in narrow lobes.
    return math.exp((both - sin_l * sine - 1.0) / width) * bessel(x) / (width * (1.0 - math.exp(-2.0 / width)))


@njit(cache=True, nogil=True)
def bessel(x: float) -> float:
    """Return exp(-x) I_0(x), to 2e-7 (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2)."""
    t = (x / 3.75) ** 2
    if t < 1.0:
        tail = 1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813))
        return math.exp(-x) * (1.0 + t * (3.5156229 + t * (3.0899424 + t * tail)))
    u = 3.75 / x
    tail = 0.00916281 + u * (-0.02057706 + u * (0.02635537 + u * (-0.01647633 + u * 0.00392377)))
    return (0.39894228 + u * (0.01328592 + u * (0.00225319 + u * (-0.00157565 + u * tail)))) / math.sqrt(x)


@njit(cache=True, nogil=True)
def at_inclination(table: np.ndarray, level: float, sine: float, first: int) -> tuple[float, float]:
    """Look up two columns of a table of `Scattering` at the square root of a colour and the sine of an inclination."""
    i, u = cell(level, COLOURS)
    j, v = cell(sine, STEPS)
    a = (1.0 - u) * (1.0 - v)
    b = (1.0 - u) * v
    c = u * (1.0 - v)
    d = u * v
    p = table[i, j]
    q = table[i, j + 1]
    r = table[i + 1, j]
    s = table[i + 1, j + 1]
    k = first + 1
    return a * p[first] + b * q[first] + c * r[first] + d * s[first], a * p[k] + b * q[k] + c * r[k] + d * s[k]


@njit(cache=True, nogil=True)
def at_azimuth(lobes: np.ndarray, level: float, sine: float, turns: float, first: int) -> tuple[float, float]:
    """Look up two of the lobes, see `Scattering`, at an azimuth [half turns] as well."""
    k, w = cell(turns, STEPS)
    p = at_inclination(lobes[:, :, k], level, sine, first)
    q = at_inclination(lobes[:, :, k + 1], level, sine, first)
    return (1.0 - w) * p[0] + w * q[0], (1.0 - w) * p[1] + w * q[1]


@njit(cache=True, nogil=True)
def cell(share: float, count: int) -> tuple[int, float]:
    """Find between which two of so many places, evenly from 0 to 1, a number lies, and how far on."""
    at = min(max(share, 0.0), 1.0) * (count - 1)
    first = min(int(at), count - 2)
    return first, at - first
