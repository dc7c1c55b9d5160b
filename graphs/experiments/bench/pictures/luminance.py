"""Luminance of a lock of hair in the studio, by `preview` with `shading = "dual"` and by a path tracer, Cycles."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.render.camera import Shot
from hairpipe.render.cycles import Exposure, Fibre, trace_hair
from hairpipe.render.dual_scattering import shade_dual
from hairpipe.render.portrait import expose_portrait
from hairpipe.values import Strands

COLOURS = {"brown": (0.112, 0.051, 0.024), "blond": (0.604, 0.38, 0.171), "black": (0.03, 0.03, 0.03)}
"""Of the hair, linear red, green and blue."""
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Weights of linear red, green and blue (ITU-R BT.709)."""
LENGTH, RADIUS, WAVE, SWING = 0.2, 0.02, 0.08, 0.0045
"""Of the lock, and length and amplitude of the waves of its strands [m]."""
SHOT = Shot(128, 128, fov=2.0, eye=(0.43, -0.03, 0.55), target=(0.0, -0.1, 0.0), grain=1)
"""From a side and somewhat above; there is nothing but hair in it."""


class Lock(NamedTuple):
    """Mean luminance of the picture of a lock, linear; a sphere of a lit, white body has about 1."""

    colour: str
    dual: float
    traced: float


def measure_luminance(echo: Callable[[str], None], strands: int = 3000, samples: int = 32) -> list[Lock]:
    """Take both pictures of a lock of each colour, and report progress; BadInput where Blender is not installed."""
    lock = make_lock(strands)
    measured = []
    for name, colour in COLOURS.items():
        echo(f"a {name} lock")
        shade = np.array(colour)
        fibre = Fibre(1.0, np.array(colour))
        with tempfile.TemporaryDirectory() as folder:
            traced = trace_hair(lock, None, SHOT, fibre, Exposure(samples, False, 0.0), Path(folder))
        dual = expose_portrait(lock, None, SHOT, shade, 1.0, shade_dual)
        measured.append(Lock(name, *(float((light @ LUMINANCE).mean()) for light in (dual, traced))))
    return measured


def make_lock(strands: int) -> Strands:
    """Hang strands, evenly spread over a disc, each a helix of a phase of its own; no two begin at one height."""
    n = np.arange(strands)[:, None]
    s = np.linspace(0.0, LENGTH, 41)
    spread, phase, height = (n * irrational % 1.0 for irrational in np.sqrt([2.0, 3.0, 5.0]))
    out = RADIUS * np.sqrt((n + 0.5) / strands)
    around = 2.0 * np.pi * spread
    turn = 2.0 * np.pi * (s / WAVE + phase)
    across = out * np.sin(around) + SWING * np.sin(turn), out * np.cos(around) + SWING * np.cos(turn)
    points = np.stack([across[0], 0.1 * LENGTH * height - s, across[1]], axis=2).reshape(-1, 3).astype(np.float32)
    return Strands(points, np.zeros_like(points), len(s) * np.arange(strands + 1, dtype=np.int32), 80e-6)
