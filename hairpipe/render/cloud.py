"""Picture of hair as particles, on a body, in a studio, without strands, by Bando, Chen, Nishita 2003, Sec. 5.

Billboards are rectangles along the hair that face an eye or a lamp; where hair points at it, they are shorter and more
opaque. Textures are streaks along the hair, faded at the ends and sides: a soft spot looks like smoke.

First, billboards in order of distance from a lamp attenuate the light behind them, on particles and body:

    l_i = mean of T under the billboard,   T <- T (1 - alpha) there

Transmittance T is stored on the rays of `shadows`; behind the body it is 0. Then billboards are painted over the film
from back to front, except behind the body.
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.render import kajiya_kay, skin
from hairpipe.render.camera import NEAR, Camera, Framing, Shot, frame_hair, place_camera
from hairpipe.render.film import backdrop, develop
from hairpipe.render.lights import studio
from hairpipe.render.portrait import NOBODY, SCALP, SCENE, check_finite
from hairpipe.render.shadows import BIAS, CELLS, apply, cells_of, front
from hairpipe.render.skin import hair_share
from hairpipe.render.surface import Sight, at_pixels, first_centre, look_at_body, seen_vertices, turn_to
from hairpipe.values import Cloud, Mesh, Particles
from hairpipe.values.random_streams import stream
from hairpipe.values.triangles import vertex_normals

SLIM = 0.5  # width of a billboard over its length
LEAST = 0.15  # sine between hair and ray below which length and opacity are constant


class Sprites(NamedTuple):
    """Billboards on a film."""

    places: np.ndarray  # column [pixels], row [pixels] and depth of their middles, (N, 3) float64
    axes: np.ndarray  # directions of the hair on the film, unit vectors, (N, 2)
    halves: np.ndarray  # half of length and width [pixels], (N, 2)
    rises: np.ndarray  # depth of the end towards the tip minus that of the middle, (N,)
    opacity: np.ndarray  # of a streak, more than 1 where hair points along the ray, (N,)
    kinds: np.ndarray  # texture of each billboard, (N,) int64


def lay_sprites(
    places: np.ndarray, along: np.ndarray, scale: np.ndarray, half: float, opacity: float, kinds: np.ndarray
) -> Sprites:
    """Lay billboards of kinds, (N,), on a film, at `places` as in Sprites, which change `along` the hair by metre.

    scale          pixels of a metre across the ray, (N,)
    half, opacity  of the length of a billboard [m], and of a streak, seen from the side

    With theta the angle between hair and ray, length is as sin theta, and opacity as 1/sin theta: as much hair is
    crossed by fewer rays, each of which crosses more.
    """
    run = np.hypot(along[:, 0], along[:, 1])
    axes = np.where(run[:, None] > 0.0, along[:, :2] / np.maximum(run, 1e-300)[:, None], (0.0, 1.0))
    sine = np.maximum(run / scale, LEAST)
    halves = (half * scale)[:, None] * np.stack([sine, np.full_like(sine, SLIM)], axis=1)
    return Sprites(places, axes, halves, half * along[:, 2], opacity / sine, kinds)


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def rows_under(row: float, axes: tuple[float, float], halves: tuple[float, float]) -> tuple[float, float]:
    """Return the first and the last row of a rectangle."""
    reach = halves[0] * abs(axes[1]) + halves[1] * abs(axes[0])
    return row - reach, row + reach


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def columns_under(
    column: float, down: float, axes: tuple[float, float], halves: tuple[float, float]
) -> tuple[float, float]:
    """Return the first and the last column of a rectangle in a row at a distance below its middle; else first > last.

    Of a point (x, y) from the middle, |x ax + y ay| <= half the length and |y ax - x ay| <= half the width.
    """
    ax, ay = axes
    ax, ay = ax if abs(ax) > 1e-9 else 1e-9, ay if abs(ay) > 1e-9 else 1e-9  # Neither is 0: divided by.
    a = (-halves[0] - down * ay) / ax
    b = (halves[0] - down * ay) / ax
    c = (down * ax - halves[1]) / ay
    d = (down * ax + halves[1]) / ay
    return column + max(min(a, b), min(c, d)), column + min(max(a, b), max(c, d))


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def turn_of(axes: tuple[float, float], halves: tuple[float, float]) -> tuple[float, float, float, float]:
    """Return the motion of pixels from the middle into texture coordinates of -1 to 1, along and across."""
    return axes[0] / halves[0], axes[1] / halves[0], -axes[1] / halves[1], axes[0] / halves[1]


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def texel_of(share: float, count: int) -> int:
    """Return the index of the texel, of `count` texels from -1 to 1, at a coordinate."""
    return min(max(int(0.5 * (share + 1.0) * count), 0), count - 1)


@njit(cache=True, nogil=True, inline="always", error_model="numpy")
def level_of(levels: tuple[np.ndarray, ...], half: float) -> int:
    """Return the finest level of textures, (kinds, along, across, 2) each, with texels not finer than pixels.

    half  of the width of a billboard [pixels]
    """
    level = 0
    while level + 1 < len(levels) and levels[level].shape[2] > 2.0 * half:
        level += 1
    return level


Levels = tuple[np.ndarray, ...]
"""From fine to coarse, each of half as many texels as the one before both ways, (KINDS, along, across, 2) float32:
cover, 0 to 1, and brightness."""

KINDS = 8  # number of textures
ALONG, ACROSS, STREAKS = 128, 64, 22  # texels of the finest level, and streaks in it
FINEST = 0.025
"""Standard deviation of the thinnest streak across, over half the width; the widest has three times as much."""
BRIGHTER = 0.55  # largest relative deviation of the brightness of a streak from the mean


@cache
def streak_levels() -> Levels:
    """Draw the textures, on average as bright as the particle."""
    rng = stream(0, "billboards")

    def drawn(low: float, high: float) -> np.ndarray:
        return rng.uniform(low, high, (KINDS, STREAKS, 1, 1))

    along = (np.arange(ALONG)[:, None] + 0.5) / ALONG * 2.0 - 1.0
    across = (np.arange(ACROSS) + 0.5) / ACROSS * 2.0 - 1.0
    middle = drawn(-0.85, 0.85) + drawn(-0.1, 0.1) * along + drawn(-0.12, 0.12) * along**2
    thin = np.exp(-0.5 * ((across - middle) / (FINEST * drawn(1.0, 3.0))) ** 2)
    begin, end = drawn(-1.0, -0.5), drawn(0.5, 1.0)
    ends = np.clip((along - begin) / 0.5, 0.0, 1.0) * np.clip((end - along) / 0.5, 0.0, 1.0)
    covers = thin * _smooth(ends) * _smooth(np.clip((1.0 - np.abs(across)) / 0.4, 0.0, 1.0)) * drawn(0.5, 1.0)
    bright = (covers * drawn(1.0 - BRIGHTER, 1.0 + BRIGHTER)).sum(axis=1) / np.maximum(covers.sum(axis=1), 1e-6)
    cover = 1.0 - np.prod(1.0 - covers, axis=1)
    shown = np.stack([cover, cover * bright], axis=3)
    levels = []
    while shown.shape[2] >= 2:
        cover, bright = shown[..., 0], shown[..., 1]
        levels.append(np.stack([cover, bright / np.maximum(cover, 1e-6)], axis=3).astype(np.float32))
        shown = 0.25 * (shown[:, ::2, ::2] + shown[:, 1::2, ::2] + shown[:, ::2, 1::2] + shown[:, 1::2, 1::2])
    return tuple(levels)


def _smooth(share: np.ndarray) -> np.ndarray:
    return share * share * (3.0 - 2.0 * share)


DARK = 1e-4  # least light: that of the body's own shadow


def transmittances(sprites: Sprites, levels: Levels, others: np.ndarray, begins: np.ndarray) -> np.ndarray:
    """Return the share of a lamp's light that reaches billboards, (N,), and then other points, (V,).

    Places are columns, rows and depths of the rays of the lamp; the body begins at depths (rows, columns).
    """
    order = np.argsort(np.concatenate([sprites.places[:, 2], others[:, 2]]), kind="stable")
    light = np.empty(len(order))
    _pass(light, np.ones(begins.shape), sprites, levels, others, begins, order)
    return np.maximum(light, DARK)


@njit(cache=True, nogil=True, error_model="numpy")
def _pass(
    light: np.ndarray,
    through: np.ndarray,
    sprites: Sprites,
    levels: Levels,
    others: np.ndarray,
    begins: np.ndarray,
    order: np.ndarray,
) -> None:
    count = len(sprites.places)
    for n in order:  # From the lamp on: each attenuates only later ones.
        light[n] = (
            _darken(through, sprites, levels, begins, n) if n < count else _read(through, others[n - count], begins)
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _darken(through: np.ndarray, sprites: Sprites, levels: Levels, begins: np.ndarray, n: int) -> float:
    """Return the light on billboard n, on average over its texture, and attenuate its rays, in place."""
    height, width = through.shape
    column, row, depth = sprites.places[n, 0], sprites.places[n, 1], sprites.places[n, 2]
    axes, halves = (sprites.axes[n, 0], sprites.axes[n, 1]), (sprites.halves[n, 0], sprites.halves[n, 1])
    texture = levels[level_of(levels, halves[1])][sprites.kinds[n]]
    along, across, _ = texture.shape
    opacity, rise = sprites.opacity[n], sprites.rises[n]
    sx, sy, wx, wy = turn_of(axes, halves)
    taken = total = 0.0
    top, bottom = rows_under(row, axes, halves)
    for i in range(first_centre(top, height), first_centre(bottom, height)):
        y = i + 0.5 - row
        left, right = columns_under(column, y, axes, halves)
        for j in range(first_centre(left, width), first_centre(right, width)):
            x = j + 0.5 - column
            s, w = x * sx + y * sy, x * wx + y * wy
            alpha = min(opacity * texture[texel_of(s, along), texel_of(w, across), 0], 1.0)
            total += alpha
            if depth + s * rise < begins[i, j] + BIAS:
                taken += alpha * through[i, j]
            through[i, j] *= 1.0 - alpha
    return taken / total if total > 0.0 else 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _read(through: np.ndarray, at: np.ndarray, begins: np.ndarray) -> float:
    """Return the light at a point, interpolated between the centres of four rays; 1 outside."""
    height, width = through.shape
    x, y = at[0] - 0.5, at[1] - 0.5
    if not (0.0 <= x < width - 1 and 0.0 <= y < height - 1):
        return 1.0
    i, j = int(y), int(x)
    taken = 0.0
    for a in range(2):
        for b in range(2):
            weight = (y - i if a else 1.0 - (y - i)) * (x - j if b else 1.0 - (x - j))
            taken += weight * through[i + a, j + b] * (at[2] < begins[i + a, j + b] + BIAS)
    return taken


SUNK, FADE = 0.010, 0.006
"""Depth below the skin to which a billboard is visible, and of its fading [m]: billboards are flat, skin is round."""


def paint(film: np.ndarray, depth: np.ndarray, sprites: Sprites, colours: np.ndarray, levels: Levels) -> None:
    """Paint billboards of linear colours, (N, 3), over the film, (height, width, 3), the farthest first, in place."""
    order = np.argsort(-sprites.places[:, 2], kind="stable")
    _paint(film, depth, sprites, colours.astype(np.float32), levels, order)


@njit(cache=True, nogil=True, error_model="numpy")
def _paint(
    film: np.ndarray, depth: np.ndarray, sprites: Sprites, colours: np.ndarray, levels: Levels, order: np.ndarray
) -> None:
    height, width = depth.shape
    for n in order:  # The farthest first: each covers those behind it.
        column, row, z = sprites.places[n, 0], sprites.places[n, 1], sprites.places[n, 2]
        if not z > NEAR:
            continue
        axes, halves = (sprites.axes[n, 0], sprites.axes[n, 1]), (sprites.halves[n, 0], sprites.halves[n, 1])
        texture = levels[level_of(levels, halves[1])][sprites.kinds[n]]
        along, across, _ = texture.shape
        opacity = np.float32(sprites.opacity[n])
        rise = sprites.rises[n]
        sx, sy, wx, wy = turn_of(axes, halves)
        red, green, blue = colours[n]
        top, bottom = rows_under(row, axes, halves)
        for i in range(first_centre(top, height), first_centre(bottom, height)):
            y = i + 0.5 - row
            left, right = columns_under(column, y, axes, halves)
            for j in range(first_centre(left, width), first_centre(right, width)):
                x = j + 0.5 - column
                s = x * sx + y * sy
                before = depth[i, j] + SUNK - z - s * rise
                if before > 0.0:
                    a = texel_of(s, along)
                    b = texel_of(x * wx + y * wy, across)
                    bright = texture[a, b, 1]
                    alpha = np.float32(min(opacity * texture[a, b, 0], 1.0) * min(before * (1.0 / FADE), 1.0))
                    film[i, j, 0] += alpha * (bright * red - film[i, j, 0])
                    film[i, j, 1] += alpha * (bright * green - film[i, j, 1])
                    film[i, j, 2] += alpha * (bright * blue - film[i, j, 2])


HALF = 1.6  # half of a billboard's length over the range of particles, which is about their spacing
OPACITY = 0.6  # opacity of a streak
SHADES = 0.25  # variation of the brightness of strands: a factor of 2 to this power, up or down


class CloudStyle(NamedTuple):
    """Style of drawn particles."""

    particles: Particles  # at rest
    framing: Framing  # of the groom
    buried: int  # number of particles below the skin, the first ones, which move with the roots and are not drawn
    half: float  # half the length of billboards [m]
    kinds: np.ndarray  # texture of every other particle, (N,)
    colour: np.ndarray  # of the hair, linear, (3,)
    colours: np.ndarray  # of every other particle, linear, (N, 3)


def style_cloud(particles: Particles, colour: np.ndarray, size: float) -> CloudStyle:
    """Choose how particles are drawn in a linear colour, (3,), at a size over that which covers hair evenly; pure."""
    framing = frame_hair(particles.hair.points, particles.hair.offsets)
    buried = int(np.count_nonzero(particles.arcs < 0.0))
    shade = np.exp2(SHADES * kajiya_kay.noise(len(particles.hair.ids), 1))[particles.strands[buried:]]
    kinds = np.arange(buried, len(particles.points)) % KINDS
    colours = np.clip(shade[:, None] * colour, 0.0, 0.95)
    half = HALF * size * particles.range
    return CloudStyle(particles, framing, buried, half, kinds, colour, colours)


def draw_cloud(cloud: Cloud, style: CloudStyle, body: Mesh | None, shot: Shot) -> np.ndarray:
    """Draw particles as billboards, and the body under them, (height, width, 3) uint8, sRGB.

    Raises BadInput where the cloud or the body does not match, or a position is not finite.
    """
    body = NOBODY if body is None else body
    check(cloud, style.particles, body)
    shift = cloud.points[: style.buried] - style.particles.points[: style.buried]  # of particles below the skin
    framing = Framing(style.framing.target + (shift.mean(axis=0) if len(shift) else 0.0), style.framing.radius)
    camera = place_camera(shot, framing)
    film = backdrop(camera.height, camera.width)
    sight = look_at_body(body, camera)
    shown = Cloud(*(values[style.buried :] for values in (cloud.points, cloud.velocities, cloud.directions)))
    hair, flesh = _shaded(shown, style, body, sight, (framing, camera))
    film[sight.rows, sight.columns] = at_pixels(sight, body.triangles, flesh)
    places = camera.project(shown.points)
    ways = shown.directions @ camera.axes.T
    x, y, z = camera.see(shown.points).T
    scale = camera.focal / np.maximum(z, NEAR)
    aside = ways[:, :2] - np.stack([x, y], axis=1) * (scale / camera.focal * ways[:, 2])[:, None]
    along = np.column_stack([scale[:, None] * aside * (1.0, -1.0), ways[:, 2]])
    sprites = lay_sprites(places, along, scale, style.half, OPACITY, style.kinds)
    paint(film, sight.depth, sprites, hair, streak_levels())
    return develop(film, shot.grain)


def check(cloud: Cloud, particles: Particles, body: Mesh) -> None:
    """Raise BadInput for what cannot be drawn."""
    if len(cloud.points) != len(particles.points):
        what = f"a cloud of {len(cloud.points)} particles, at rest there are {len(particles.points)}"
        raise BadInput(what, where="in.cloud", right="the cloud simulated from in.particles")
    bound = particles.hair.root_triangles.max(initial=-1)
    if body is not NOBODY and bound >= len(body.triangles):
        what = f"hair grows from triangle {bound} of a body that has {len(body.triangles)}"
        raise BadInput(what, where="in.body", right="the body that the groom was grown on")
    check_finite(cloud.points, "particle", "in.cloud")
    check_finite(cloud.directions, "particle", "in.cloud")
    check_finite(body.points, "vertex", "in.body")


def _shaded(
    cloud: Cloud, style: CloudStyle, body: Mesh, sight: Sight, place: tuple[Framing, Camera]
) -> tuple[np.ndarray, np.ndarray]:
    """Return light from particles and vertices of the body to the eye, linear, (n, 3) each; 0 for invisible ones."""
    framing, camera = place
    seen = seen_vertices(sight, body.triangles)
    points = body.points[seen]
    normals = vertex_normals(body)[seen]
    turn_to(camera.eye, points, normals)
    share = np.zeros((0, 1))
    if len(points):
        rest = style.particles.hair
        roots = np.einsum("sc,sci->si", rest.root_barycentrics, body.points[body.triangles[rest.root_triangles]])
        share = SCALP * hair_share(points, roots, camera.axes)[:, None]
    clay = skin.CLAY + share * (0.5 * style.colour - skin.CLAY)
    tilts = np.full(len(cloud.points), np.sin(kajiya_kay.TILT))
    no_normals = np.zeros_like(cloud.points)
    fibres = kajiya_kay.Fibres(cloud.points, cloud.directions, no_normals, style.colours, tilts)
    hair = kajiya_kay.AMBIENT * style.colours
    flesh = skin.AMBIENT * clay
    for light in studio(camera.axes):
        cell, to_cells = cells_of(light, framing.target, SCENE * framing.radius, CELLS)
        along = _of_rays(cloud.directions @ to_cells[:, :3].T)
        scale = np.full(len(along), 1.0 / cell)
        middles = _of_rays(apply(to_cells, cloud.points))
        sprites = lay_sprites(middles, along, scale, style.half, OPACITY, style.kinds)
        begins = front(apply(to_cells, body.points), body.triangles, 1, CELLS)
        depths = -np.log(transmittances(sprites, streak_levels(), _of_rays(apply(to_cells, points)), begins))
        on_hair, on_skin = depths[: len(hair)] / kajiya_kay.DENSITY, depths[len(hair) :] / skin.DENSITY
        kajiya_kay.add_light(hair, fibres, camera.eye, light, on_hair)
        skin.add_light(flesh, points, normals, clay, camera.eye, light, on_skin)
    shed = np.zeros_like(body.points)
    shed[seen] = flesh
    return hair, shed


def _of_rays(cells: np.ndarray) -> np.ndarray:
    """Return columns, rows and depths of a lamp's rays, see `front`, from places in its cells, (n, 3)."""
    return np.ascontiguousarray(cells[:, [1, 0, 2]])
