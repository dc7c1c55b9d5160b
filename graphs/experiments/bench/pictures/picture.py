"""Cost of a picture: processor seconds of `preview`, when nothing is left to compile, by part; and its truth."""

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hairpipe.bench.machine import Machine, this_machine
from hairpipe.bench.shares import shares_of
from hairpipe.body.mannequin.bust import build_bust
from hairpipe.data import Mesh, Strands
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.head import LENGTH, mesh_at, no_image
from hairpipe.graphs.experiments.bench.pictures.luminance import Lock, measure_luminance
from hairpipe.groom.cutting import Cut
from hairpipe.groom.grow.growing import grow
from hairpipe.groom.grow.paint import Canvas
from hairpipe.groom.grow.style import PaintedMetres, Style
from hairpipe.render.deep_shadow import DeepShadow
from hairpipe.render.framing import Shot, frame_hair, place_camera
from hairpipe.render.lights import studio
from hairpipe.render.portrait import cast_shadows, draw_portrait, drawn_width
from hairpipe.sim.material import Material

SHOT, BROWN = Shot(720, 720, grain=1), np.array([0.11, 0.05, 0.025])
"""Of the picture; colour of the hair, linear."""
_PARTS = {
    "raster/lines": "hair",
    "raster/fragments": "hair",
    "raster/tiles": "order",
    "shading/kajiya_kay": "light on hair",
    "shading/skin": "body",
    "raster/surface": "body",
    "shading/scalp_tint": "body",
    "shadows": "shadows",
}
"""Hair on the film, its order, light that it sheds, the body, shadows of both; the rest is film and camera."""
PARTS = (*dict.fromkeys(_PARTS.values()), "film")


class Sizes(NamedTuple):
    """What is measured, and how often.

    hair   strands, and points of each
    times  that a picture is taken
    """

    hair: tuple[tuple[int, int], ...] = ((4_000, 26), (10_000, 51), (100_000, 26))
    times: int = 5


FULL = Sizes()


class Case(NamedTuple):
    """A picture of so many strands and points: the least processor seconds of all takes.

    shares  of its parts
    deep    the same with deep shadow maps, taken in turn
    knots   of a texel of these maps where there is any, on average over all lamps
    """

    strands: int
    points: int
    seconds: float
    shares: dict[str, float]
    deep: float
    knots: float


class Report(NamedTuple):
    """All of it; no locks where there is no path tracer to compare with."""

    machine: Machine
    cases: list[Case]
    locks: list[Lock]


def measure_picture(say: Callable[[str], None], sizes: Sizes = FULL) -> Report:
    """Take pictures of hair at rest on our bust, and report progress."""
    bust, cases = build_bust(), []
    for strands, points in sizes.hair:
        say(f"{strands:,} strands of {points} points")
        groom = grow(Canvas(bust, no_image, 0), Style(length=PaintedMetres(LENGTH)), None, strands, Cut(points - 1))
        at_rest = groom.points.astype(np.float32)
        hair = Strands(at_rest, np.zeros_like(at_rest), groom.offsets, Material().diameter)
        cases.append(_case(hair, mesh_at(bust, 0.0), sizes.times))
    try:
        locks = measure_luminance(say)
    except BadInput as missing:
        say(f"no luminance: {missing}")
        locks = []
    return Report(this_machine(), cases, locks)


def _case(hair: Strands, body: Mesh, times: int) -> Case:
    cube, deep = (partial(draw_portrait, hair, body, SHOT, BROWN, 1.0, shadow=name) for name in ("cube", "deep"))
    cube()
    deep()
    takes, deep_takes = [], []
    for _ in range(times):
        takes.append(shares_of(cube, part_of, PARTS, time.process_time))
        begun = time.process_time()
        deep()
        deep_takes.append(time.process_time() - begun)
    strands = len(hair.offsets) - 1
    least = min(takes, key=lambda take: take[0])
    return Case(strands, len(hair.points) // strands, *least, min(deep_takes), knots_of(hair, body))


def knots_of(hair: Strands, body: Mesh) -> float:
    """Count the knots of the deep shadow maps, over the texels that have any."""
    framing = frame_hair(np.asarray(hair.points, float), hair.offsets)
    camera = place_camera(SHOT, framing)
    width = drawn_width(hair, framing, camera, SHOT.grain)
    maps = cast_shadows(hair, body, framing, studio(camera.axes), width, "deep")
    held = np.concatenate([np.diff(each.starts) for each in maps if isinstance(each, DeepShadow)])
    return float(held[held > 0].mean())


def part_of(path: Path) -> str:
    """Name the part of a picture that a file stands for."""
    stem = path.with_suffix("").as_posix()
    return next((part for end, part in _PARTS.items() if stem.endswith(f"render/{end}")), "film")
