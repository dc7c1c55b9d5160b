"""Shading of hair by dual scattering, after Zinke, Yuksel, Weber, Keyser 2008, with the lobes of `fibre.py`.

A lamp's light goes through hair in two streams, away from the lamp and back. With a_f and a_b, what a hair sends on and
back, n, the hairs between a place and the lamp, and N, all hairs on that ray, of which the last sends nothing back,

    dD/dn = -(1 - a_f) D + a_b U,  dU/dn = (1 - a_f) U - a_b D,  D(0) = 1,  U(N) = 0.

These are the streams of Schuster 1905, and of Kubelka and Munk 1931. The share exp(-n) of D is the lamp's own light,
scattered by R, TT and TRT. What else comes, D - exp(-n) from the lamp's side and U from the other, is spread over half
of all azimuths, and along the hair the wider, the more hairs it met. We differ from the paper: it counts hairs one by
one, D as a_f^n, and for U it sums the light that turns once or three times in deep hair. n of a map is a mean, hair may
be thin, and white hair shall lose nothing.
"""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit

from hairpipe.render.lights import Light, Shade
from hairpipe.render.shading.fibre import COLOURS, STEPS, WIDTHS, Scattering, tabulate
from hairpipe.render.shading.kajiya_kay import AMBIENT, Fibres, lay_fibres
from hairpipe.render.shading.skin import IRRADIANCE

R, TT, TRT = WIDTHS
BEYOND = 1e4
"""How far from the lamp all hairs of a ray are behind [cells]."""
FLAT = 1e-3
"""Least extinction of the streams over a hair: less makes no difference, and none would divide by 0."""


def shade_dual(
    points: np.ndarray,
    offsets: np.ndarray,
    sites: np.ndarray,
    colour: np.ndarray,
    eye: np.ndarray,
    shadows: Sequence[Shade],
) -> np.ndarray:
    """Light that sites on the strands send to the eye, linear, (n, 3) float64; arguments as of `shade_hair`."""
    fibres = lay_fibres(points, offsets, sites, colour, None)
    shed = AMBIENT * fibres.colours
    for shadow in shadows:
        far = fibres.points - BEYOND * shadow.cell * shadow.light.towards
        met = np.stack([shadow.between(at) for at in (fibres.points, far)], axis=1)
        add_scattered(shed, fibres, eye, shadow.light, met, tabulate())
    return shed


@njit(cache=True, nogil=True)
def add_scattered(
    shed: np.ndarray, fibres: Fibres, eye: np.ndarray, light: Light, met: np.ndarray, table: Scattering
) -> None:
    """Add what one lamp makes points of fibres send to the eye, into `shed` (p, 3).

    eye  [m], (3,)
    met  hairs between them and the lamp, and all on that ray, (p, 2)

    Scales tilted by s turn the lobes R, TT, TRT about the mirrored cone by 2 s to the root, s and 3 s to the tip.
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
        azimuth = math.acos(min(max(kappa, -1.0), 1.0)) / math.pi
        apart = math.sqrt(max(0.0, 0.5 - 0.5 * (cos_l * cos_e + sin_l * sin_e)))
        n, last = met[i, 0], max(met[i, 0], met[i, 1])
        direct = math.exp(-n)
        turn, s = math.sqrt(1.0 - tilts[i] ** 2), tilts[i]
        sin_2, cos_2 = 2.0 * s * turn, 1.0 - 2.0 * s * s
        sin_3, cos_3 = s * cos_2 + turn * sin_2, turn * cos_2 - s * sin_2
        cone_r = cone(sin_l, cos_l, sin_e * cos_2 + cos_e * sin_2, cos_e * cos_2 - sin_e * sin_2, R)
        cone_tt = cone(sin_l, cos_l, sin_e * turn - cos_e * s, cos_e * turn + sin_e * s, TT)
        cone_trt = cone(sin_l, cos_l, sin_e * cos_3 - cos_e * sin_3, cos_e * cos_3 + sin_e * sin_3, TRT)
        # How far light spreads hardly depends on the colour: green stands for all.
        _, _, crossing, back_again = at_inclination(table.streams, math.sqrt(colours[i, 1]), abs(sin_l))
        cone_d = cone(sin_l, cos_l, sin_e, cos_e, back_again + n * crossing)
        cone_u = cone(sin_l, cos_l, sin_e, cos_e, 2.0 * back_again)
        for c in range(3):
            level = math.sqrt(colours[i, c])
            on, back, _, _ = at_inclination(table.streams, level, abs(sin_l))
            down, up = streams(on, back, n, last)
            r, tt, trt, spread = at_azimuth(table.lobes, level, apart, azimuth)
            sent = direct * (cone_r * r + cone_tt * tt + cone_trt * trt) + (down - direct) * cone_d * spread
            if up > 0.0:
                sent += up * cone_u * at_azimuth(table.lobes, level, apart, 1.0 - azimuth)[3]
            shed[i, c] += IRRADIANCE * light.colour[c] * sent


@njit(cache=True, nogil=True)
def streams(on: float, back: float, n: float, last: float) -> tuple[float, float]:
    """Light on its way from the lamp, over what it sheds, behind n of the last hairs, and light on its way back."""
    lost = 1.0 - on
    k = max(math.sqrt(max(lost * lost - back * back, 0.0)), FLAT)
    echo, end = math.exp(-2.0 * k * (last - n)), math.exp(-2.0 * k * last)
    left = math.exp(-k * n) / (k + lost + (k - lost) * end)
    return left * (k + lost + (k - lost) * echo), left * back * (1.0 - echo)


@njit(cache=True, nogil=True)
def cone(sin_l: float, cos_l: float, sin_e: float, cos_e: float, width: float) -> float:
    """Light that goes off at an inclination, of that which comes at another, in a lobe of a variance (d'Eon, Eq. 7).

    csch(1/v)/(2 v) exp(-sin sin/v) I_0(cos cos/v), which over all directions is 2 pi; exponents are drawn together.
    """
    both = abs(cos_l * cos_e)
    x = both / width
    return math.exp((both - sin_l * sin_e - 1.0) / width) * bessel(x) / (width * (1.0 - math.exp(-2.0 / width)))


@njit(cache=True, nogil=True)
def bessel(x: float) -> float:
    """exp(-x) I_0(x), to 2e-7 (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2)."""
    t = (x / 3.75) ** 2
    if t < 1.0:
        tail = 1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813))
        return math.exp(-x) * (1.0 + t * (3.5156229 + t * (3.0899424 + t * tail)))
    u = 3.75 / x
    tail = 0.00916281 + u * (-0.02057706 + u * (0.02635537 + u * (-0.01647633 + u * 0.00392377)))
    return (0.39894228 + u * (0.01328592 + u * (0.00225319 + u * (-0.00157565 + u * tail)))) / math.sqrt(x)


@njit(cache=True, nogil=True)
def at_inclination(streams: np.ndarray, level: float, sine: float) -> tuple[float, float, float, float]:
    """Look up what a table of `Scattering` holds at the square root of a colour and the sine of an inclination."""
    i, u = cell(level, COLOURS)
    j, v = cell(sine, STEPS)
    a, b, c, d = (1.0 - u) * (1.0 - v), (1.0 - u) * v, u * (1.0 - v), u * v
    p, q, r, s = streams[i, j], streams[i, j + 1], streams[i + 1, j], streams[i + 1, j + 1]
    return (
        a * p[0] + b * q[0] + c * r[0] + d * s[0],
        a * p[1] + b * q[1] + c * r[1] + d * s[1],
        a * p[2] + b * q[2] + c * r[2] + d * s[2],
        a * p[3] + b * q[3] + c * r[3] + d * s[3],
    )


@njit(cache=True, nogil=True)
def at_azimuth(lobes: np.ndarray, level: float, sine: float, turns: float) -> tuple[float, float, float, float]:
    """Look up lobes, see `Scattering`, at an azimuth [half turns] as well."""
    k, w = cell(turns, STEPS)
    p, q = at_inclination(lobes[:, :, k], level, sine), at_inclination(lobes[:, :, k + 1], level, sine)
    return (
        (1.0 - w) * p[0] + w * q[0],
        (1.0 - w) * p[1] + w * q[1],
        (1.0 - w) * p[2] + w * q[2],
        (1.0 - w) * p[3] + w * q[3],
    )


@njit(cache=True, nogil=True)
def cell(share: float, count: int) -> tuple[int, float]:
    """Find between which two of so many places, evenly from 0 to 1, a number lies, and how far on."""
    at = min(max(share, 0.0), 1.0) * (count - 1)
    first = min(int(at), count - 2)
    return first, at - first
