"""Cost of a picture: processor seconds of `preview`, when nothing is left to compile, by part; and its truth."""

import time
from functools import partial
from pathlib import Path

import numpy as np

from hairpipe.body.bust import build_bust
from hairpipe.errors import BadInput
from hairpipe.graphs.experiments.bench.head import LENGTH, mesh_at, no_image
from hairpipe.graphs.experiments.bench.pictures.luminance import measure_luminance
from hairpipe.graphs.experiments.bench.report import Case, Echo, Report, in_seconds, make_report
from hairpipe.graphs.experiments.bench.shares import shares_of
from hairpipe.groom.growing import grow
from hairpipe.groom.resampling import Cut
from hairpipe.groom.settings import Style
from hairpipe.render.camera import Shot, frame_hair, place_camera
from hairpipe.render.deep_shadow import DeepShadow
from hairpipe.render.film import develop
from hairpipe.render.lights import studio
from hairpipe.render.portrait import cast_shadows, drawn_width, expose_portrait
from hairpipe.strands.material import Material
from hairpipe.values import Mesh, Strands
from hairpipe.values.painting import Canvas, PaintedMetres

SHOT = Shot(720, 720, grain=1)
BROWN = np.array([0.11, 0.05, 0.025])
"""Of the picture; colour of the hair, linear."""
_PARTS = {
    "lines": "hair",
    "kajiya_kay": "light on hair",
    "skin": "body",
    "surface": "body",
    "shadows": "shadows",
}
"""Hair on the film and its order, light that it sheds, the body, shadows of both; the rest is film and camera."""
PARTS = (*dict.fromkeys(_PARTS.values()), "film")


HAIR = ((4_000, 26), (10_000, 51), (100_000, 26))
"""Strands, and points of each."""


def measure_picture(echo: Echo, sizes: tuple[tuple[int, int], ...] = HAIR, times: int = 5) -> Report:
    """Take pictures of hair at rest on our bust, and report progress.

    sizes  strands, and points of each
    times  that a picture is taken
    """
    bust = build_bust()
    cases = list[Case]()
    for strands, points in sizes:
        echo(f"{strands:,} strands of {points} points")
        groom = grow(Canvas(bust, no_image, 0), Style(length=PaintedMetres(LENGTH)), None, strands, Cut(points - 1))
        at_rest = groom.points.astype(np.float32)
        hair = Strands(at_rest, np.zeros_like(at_rest), groom.offsets, Material().diameter)
        cases.append({"strands": strands, "points": points, **_costs(hair, mesh_at(bust, 0.0), times)})
    try:
        locks = measure_luminance(echo)
    except BadInput as missing:
        echo(f"no luminance: {missing}")
        locks = []
    luminance: list[Case] = [
        {"colour": lock.colour, "dual": lock.dual, "Cycles": lock.traced, "ratio": lock.dual / lock.traced}
        for lock in locks
    ]
    return make_report(__name__, {"pictures": cases, "luminance": luminance})


def _costs(hair: Strands, body: Mesh, times: int) -> Case:
    """Find the least processor seconds of all takes, with those of the parts, and with deep shadows, taken in turn."""

    def take(shadow: str) -> np.ndarray:
        return develop(expose_portrait(hair, body, SHOT, BROWN, 1.0, shadow=shadow), SHOT.grain)

    cube, deep = partial(take, "cube"), partial(take, "deep")
    cube()
    deep()
    takes, deep_takes = [], []
    for _ in range(times):
        takes.append(shares_of(cube, part_of, PARTS, time.process_time))
        begun = time.process_time()
        deep()
        deep_takes.append(time.process_time() - begun)
    seconds, shares = min(takes, key=lambda take: take[0])
    costs = {"whole [s]": seconds, **in_seconds(shares), "with deep shadows [s]": min(deep_takes)}
    return costs | {"knots a texel": knots_of(hair, body)}


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
