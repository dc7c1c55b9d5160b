"""Gusts: a random divergence-free velocity field, smooth in space and time, advected by the wind.

A sum of plane waves (Kraichnan, Diffusion by a random velocity field, 1970),

    u(x, t) = sum_m a_m cos(k_m . (x - U t) + w_m t + p_m),   a_m . k_m = 0,

so that div u = 0. The lengths of k_m follow E(k) ~ k^4 exp(-k^2 l^2 / 2), those of isotropic turbulence whose
longitudinal correlation is exp(-r^2 / (2 l^2)); frequencies w_m are normal with deviation 1 / duration. Both are taken
at even quantiles, and amplitudes come in threes along an orthogonal frame, so that even a few modes have these
statistics: the mean square of every component is strength^2.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hairpipe.geometry.compile import inlined
from hairpipe.laws.settings import Gusts
from hairpipe.values.random_streams import stream

FRAMES = 16
"""Orthogonal frames of random directions; each gives three modes."""
CHUNK = 512
"""Number of points of a chunk: their coordinates stay in the cache of a thread for all modes."""
_SINE = tuple((-1.0) ** n * np.pi ** (2 * n + 1) / float(np.prod(np.arange(1.0, 2 * n + 2))) for n in range(8))
"""Taylor coefficients of sin(pi y): to 6e-12 for |y| < 1/2."""


class Modes(NamedTuple):
    """Plane waves.

    waves        k / 2 pi [1/m], (m, 3)
    frequencies  w / 2 pi [1/s], (m,)
    phases       p / 2 pi, (m,)
    amplitudes   [m/s], (m, 3)
    """

    waves: np.ndarray
    frequencies: np.ndarray
    phases: np.ndarray
    amplitudes: np.ndarray


def modes_of(gusts: Gusts) -> Modes:
    """Draw the modes of gusts from their seed."""
    from scipy.special import (
        gammaincinv,
        ndtri,
    )  # here: the import takes 0.2 s in every worker, and most shots have no gusts

    chance = stream(gusts.seed, "gusts")
    count = 3 * FRAMES
    quantiles = (np.arange(count) + 0.5) / count
    frames = np.linalg.qr(chance.normal(size=(FRAMES, 3, 3)))[0].transpose(0, 2, 1)
    numbers = np.sqrt(2.0 * gammaincinv(2.5, chance.permutation(quantiles))) / (2.0 * np.pi * gusts.size)
    frequencies = ndtri(chance.permutation(quantiles)) / (2.0 * np.pi * gusts.duration)
    amplitude = gusts.strength * np.sqrt(2.0 / FRAMES)
    return Modes(
        numbers[:, None] * frames.reshape(-1, 3),
        frequencies,
        chance.uniform(size=count),
        amplitude * np.roll(frames, 1, axis=1).reshape(-1, 3),
    )


def add_gusts(modes: Modes, wind: np.ndarray, points: np.ndarray, seconds: float, air: np.ndarray) -> None:
    """Add the velocity of gusts at points, (P, 3) [m], and an absolute time, to that of air, (P, 3) [m/s], in place.

    wind  advecting wind [m/s], (3,)
    """
    turns = modes.phases + seconds * (modes.frequencies - modes.waves @ wind)
    _add_waves(modes.waves, turns - np.floor(turns), modes.amplitudes, points, air)


@njit(cache=True, parallel=True)
def _add_waves(waves, phases, amplitudes, points, air):
    """Add sum_m a_m cos(2 pi (k_m . x + p_m)) at every point, in place."""
    chunks = (len(points) + CHUNK - 1) // CHUNK
    for chunk in prange(chunks):
        first = np.int64(chunk) * CHUNK
        rows = slice(first, min(first + CHUNK, len(points)))
        _add_to_chunk(waves, phases, amplitudes, points[rows], air[rows])


@njit(cache=True)
def _add_to_chunk(waves, phases, amplitudes, points, air):
    """Add all modes to a few points; the loop over points is the inner one, for the compiler to vectorise."""
    x = points[:, 0].copy()  # Contiguous: a stride of three prevents vectorisation of the inner loop.
    y = points[:, 1].copy()
    z = points[:, 2].copy()
    u, v, w = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    for m in range(len(waves)):  # Modes outside: sums at a point have the order of modes in every chunk.
        kx = waves[m, 0]
        ky = waves[m, 1]
        kz = waves[m, 2]
        phase = phases[m]
        ax, ay, az = amplitudes[m, 0], amplitudes[m, 1], amplitudes[m, 2]
        for p in range(len(x)):
            share = _cosine(kx * x[p] + ky * y[p] + kz * z[p] + phase)
            u[p] += ax * share
            v[p] += ay * share
            w[p] += az * share
    for p in range(len(x)):
        air[p, 0] += u[p]
        air[p, 1] += v[p]
        air[p, 2] += w[p]


@inlined
def _cosine(turns: float) -> float:
    """Return cos(2 pi turns) = 1 - 2 sin^2(pi turns), without a call, which would prevent vectorisation."""
    y = turns - np.floor(turns + 0.5)
    s = y * y
    sine = _SINE[6] + s * _SINE[7]
    sine = _SINE[4] + s * (_SINE[5] + s * sine)
    sine = _SINE[2] + s * (_SINE[3] + s * sine)
    sine = y * (_SINE[0] + s * (_SINE[1] + s * sine))
    return 1.0 - 2.0 * sine * sine
