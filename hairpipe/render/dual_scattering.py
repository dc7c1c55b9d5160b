"""Shading of hair by dual scattering, after Zinke, Yuksel, Weber, Keyser 2008, with the lobes of `fibre.py`.

A lamp's light goes through hair in two streams, away from the lamp and back. With a_f and a_b, what a hair sends on and
back, n, the hairs between a place and the lamp, and N, all hairs on that ray, of which the last sends nothing back,

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

import numpy as np
from numba import njit

from hairpipe.render.fibre import COLOURS, STEPS, TILTS, WIDTHS, Scattering, absorption_of, colour_of, tabulate
from hairpipe.render.film import EDGE
from hairpipe.render.kajiya_kay import Fibres, lay_fibres, strand_colours
from hairpipe.render.lights import Light, Shade
from hairpipe.render.skin import IRRADIANCE

R, TT, TRT = WIDTHS
BEYOND = 1e4
"""Distance from the lamp behind which all hairs of a ray are [cells]."""
FLAT = 1e-3
"""Least extinction of the streams over a hair: less makes no difference, and none would divide by 0."""
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
