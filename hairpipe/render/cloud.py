"""Picture of hair as particles, on a body, in a studio, without strands.

Light of a lamp on particles and body: billboards in order of distance from the lamp attenuate the light behind.

The first pass of Bando, Chen, Nishita 2003, Sec. 5:

    l_i = mean of T under the billboard,   T <- T (1 - alpha) there

Transmittance T is stored on the rays of `shadows`; behind the body it is 0.

Billboards painted over the film from back to front, except behind the body.

The second pass of Bando, Chen, Nishita 2003, Sec. 5.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from hairpipe.errors import BadInput
from hairpipe.geometry.triangles import vertex_normals
from hairpipe.render import kajiya_kay, skin
from hairpipe.render.camera import NEAR, Camera, Framing, Shot, frame_hair, place_camera
from hairpipe.render.film import backdrop, develop
from hairpipe.render.lights import studio
from hairpipe.render.portrait import NOBODY, SCALP, SCENE
from hairpipe.render.shadows import BIAS, CELLS, apply, cells_of, front
from hairpipe.render.skin import hair_share
from hairpipe.render.sprites import (
    KINDS,
    Levels,
    Sprites,
    columns_under,
    lay_sprites,
    level_of,
    rows_under,
    streak_levels,
    texel_of,
)
from hairpipe.render.surface import Sight, at_pixels, first_centre, look_at_body, seen_vertices, turn_to
from hairpipe.values import Cloud, Mesh, Particles

DARK = 1e-4
"""Least light: that of the body's own shadow."""


def transmittances(sprites: Sprites, levels: Levels, others: np.ndarray, front: np.ndarray) -> np.ndarray:
    """Return the share of a lamp's light that reaches billboards, (N,), and then other points, (V,); pure.

    sprites  billboards projected to the lamp: rows and columns of its rays, depths away from it
    levels   of the textures of billboards
    others   row and column, from 0 to as many as there are rays, and depth, (V, 3)
    front    depth at which the body begins, infinite outside, (rows, columns)
    """
    order = np.argsort(np.concatenate([sprites.places[:, 2], others[:, 2]]), kind="stable")
    light = np.empty(len(order))
    _pass(light, np.ones(front.shape), sprites, levels, others, front, order)
    return np.maximum(light, DARK)


@njit(cache=True, nogil=True, error_model="numpy")
def _pass(
    light: np.ndarray,
    through: np.ndarray,
    sprites: Sprites,
    levels: Levels,
    others: np.ndarray,
    front: np.ndarray,
    order: np.ndarray,
) -> None:
    """Write the light of all in order of depth, and attenuate the rays, (rows, columns), both in place."""
    count = len(sprites.places)
    for n in order:  # From the lamp on: each attenuates only later ones.
        light[n] = (
            _darken(through, sprites, levels, front, n) if n < count else _read(through, others[n - count], front)
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _darken(through: np.ndarray, sprites: Sprites, levels: Levels, front: np.ndarray, n: int) -> float:
    """Return the light on billboard n, on average over its texture, and attenuate its rays, in place."""
    height, width = through.shape
    column, row, depth = sprites.places[n, 0], sprites.places[n, 1], sprites.places[n, 2]
    axes, halves = (sprites.axes[n, 0], sprites.axes[n, 1]), (sprites.halves[n, 0], sprites.halves[n, 1])
    texture = levels[level_of(levels, halves[1])][sprites.kinds[n]]
    along, across, _ = texture.shape
    opacity, rise = sprites.opacity[n], sprites.rises[n]
    sx = axes[0] / halves[0]
    sy = axes[1] / halves[0]
    wx = -axes[1] / halves[1]
    wy = axes[0] / halves[1]
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
            if depth + s * rise < front[i, j] + BIAS:
                taken += alpha * through[i, j]
            through[i, j] *= 1.0 - alpha
    return taken / total if total > 0.0 else 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _read(through: np.ndarray, at: np.ndarray, front: np.ndarray) -> float:
    """Light at a point, interpolated between the centres of four rays; 1 outside."""
    height, width = through.shape
    x, y = at[0] - 0.5, at[1] - 0.5
    if not (0.0 <= x < width - 1 and 0.0 <= y < height - 1):
        return 1.0
    i, j = int(y), int(x)
    taken = 0.0
    for a in range(2):
        for b in range(2):
            weight = (y - i if a else 1.0 - (y - i)) * (x - j if b else 1.0 - (x - j))
            taken += weight * through[i + a, j + b] * (at[2] < front[i + a, j + b] + BIAS)
    return taken


SUNK, FADE = 0.010, 0.006
"""Depth below the skin to which a billboard is visible, and of its fading [m]: billboards are flat, skin is round."""


def paint(film: np.ndarray, depth: np.ndarray, sprites: Sprites, colours: np.ndarray, levels: Levels) -> None:
    """Paint billboards over the film, the farthest first, in place.

    film     linear red, green, blue, (height, width, 3) float32
    depth    of the body [m], (height, width)
    sprites  depth [m]; those nearer than NEAR are not drawn
    colours  linear, of the billboards, (N, 3) float64
    levels   of their textures
    """
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
        sx = axes[0] / halves[0]
        sy = axes[1] / halves[0]
        wx = -axes[1] / halves[1]
        wy = axes[0] / halves[1]
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


HALF = 1.6
"""Half of a billboard's length over the range of particles, which is about their spacing."""
OPACITY = 0.6
"""Opacity of a streak."""
SHADES = 0.25
"""Variation of the brightness of strands: a factor of 2 to this power, up or down."""


class CloudStyle(NamedTuple):
    """Style of drawn particles.

    particles  at rest
    framing    framing of the groom
    buried     number of particles below the skin, the first ones, which move with the roots and are not drawn
    half       half the length of billboards [m]
    kinds      texture of every other particle, (N,)
    colour     of the hair, linear, (3,)
    colours    of every other particle, linear, (N, 3)
    """

    particles: Particles
    framing: Framing
    buried: int
    half: float
    kinds: np.ndarray
    colour: np.ndarray
    colours: np.ndarray


def style_cloud(particles: Particles, colour: np.ndarray, size: float) -> CloudStyle:
    """Choose how particles are drawn, once a shot; pure.

    colour  of the hair, linear red, green and blue, (3,)
    size    size of billboards, over the size that covers hair evenly
    """
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
    framing = frame_cloud(cloud, style)
    camera = place_camera(shot, framing)
    film = backdrop(camera.height, camera.width)
    sight = look_at_body(body, camera)
    shown = Cloud(*(values[style.buried :] for values in (cloud.points, cloud.velocities, cloud.directions)))
    hair, flesh = _shaded(shown, style, body, sight, (framing, camera))
    film[sight.rows, sight.columns] = at_pixels(sight, body.triangles, flesh)
    paint(film, sight.depth, _seen(shown, style, camera), hair, streak_levels())
    return develop(film, shot.grain)


def frame_cloud(cloud: Cloud, style: CloudStyle) -> Framing:
    """Frame the hair at rest, moved with the particles below the skin."""
    moved = cloud.points[: style.buried] - style.particles.points[: style.buried]
    return Framing(style.framing.target + (moved.mean(axis=0) if len(moved) else 0.0), style.framing.radius)


def check(cloud: Cloud, particles: Particles, body: Mesh) -> None:
    """Raise BadInput for what cannot be drawn."""
    if len(cloud.points) != len(particles.points):
        what = f"a cloud of {len(cloud.points)} particles, at rest there are {len(particles.points)}"
        raise BadInput(what, where="in.cloud", right="the cloud simulated from in.particles")
    bound = particles.hair.root_triangles.max(initial=-1)
    if body is not NOBODY and bound >= len(body.triangles):
        what = f"hair grows from triangle {bound} of a body that has {len(body.triangles)}"
        raise BadInput(what, where="in.body", right="the body that the groom was grown on")
    places = (
        ("cloud", "particle", cloud.points),
        ("cloud", "particle", cloud.directions),
        ("body", "vertex", body.points),
    )
    for where, name, points in places:
        lost = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(lost):
            raise BadInput(f"{name} {lost[0]} is not finite", where=f"in.{where}")


def _shaded(
    cloud: Cloud, style: CloudStyle, body: Mesh, sight: Sight, place: tuple[Framing, Camera]
) -> tuple[np.ndarray, np.ndarray]:
    """Light from particles, (N, 3), and vertices of the body, (V, 3), to the eye, linear; 0 for invisible ones."""
    framing, camera = place
    seen = seen_vertices(sight, body.triangles)
    points = body.points[seen]
    normals = vertex_normals(body)[seen]
    turn_to(camera.eye, points, normals)
    clay = skin.CLAY + _haired(style, body, points, camera) * (0.5 * style.colour - skin.CLAY)
    tilts = np.full(len(cloud.points), np.sin(kajiya_kay.TILT))
    no_normals = np.zeros_like(cloud.points)
    fibres = kajiya_kay.Fibres(cloud.points, cloud.directions, no_normals, style.colours, tilts)
    hair = kajiya_kay.AMBIENT * style.colours
    flesh = skin.AMBIENT * clay
    for light in studio(camera.axes):
        cell, to_cells = cells_of(light, framing.target, SCENE * framing.radius, CELLS)
        sprites = _lit(cloud, style, cell, to_cells)
        begins = front(apply(to_cells, body.points), body.triangles, 1, CELLS)
        depths = -np.log(transmittances(sprites, streak_levels(), _of_rays(apply(to_cells, points)), begins))
        on_hair, on_skin = depths[: len(hair)] / kajiya_kay.DENSITY, depths[len(hair) :] / skin.DENSITY
        kajiya_kay.add_light(hair, fibres, camera.eye, light, on_hair)
        skin.add_light(flesh, points, normals, clay, camera.eye, light, on_skin)
    shed = np.zeros_like(body.points)
    shed[seen] = flesh
    return hair, shed


def _haired(style: CloudStyle, body: Mesh, points: np.ndarray, camera: Camera) -> np.ndarray:
    """Share of the hair's colour in the skin at points, (n, 1)."""
    if not len(points):
        return np.zeros((0, 1))
    hair = style.particles.hair
    roots = np.einsum("sc,sci->si", hair.root_barycentrics, body.points[body.triangles[hair.root_triangles]])
    return SCALP * hair_share(points, roots, camera.axes)[:, None]


def _seen(cloud: Cloud, style: CloudStyle, camera: Camera) -> Sprites:
    """Billboards projected to the camera."""
    places = camera.project(cloud.points)
    ways = cloud.directions @ camera.axes.T
    x, y, z = camera.see(cloud.points).T
    scale = camera.focal / np.maximum(z, NEAR)
    aside = ways[:, :2] - np.stack([x, y], axis=1) * (scale / camera.focal * ways[:, 2])[:, None]
    along = np.column_stack([scale[:, None] * aside * (1.0, -1.0), ways[:, 2]])
    return lay_sprites(places, along, scale, style.half, OPACITY, style.kinds)


def _lit(cloud: Cloud, style: CloudStyle, cell: float, to_cells: np.ndarray) -> Sprites:
    """Billboards projected to a lamp."""
    places = apply(to_cells, cloud.points)
    along = cloud.directions @ to_cells[:, :3].T
    scale = np.full(len(places), 1.0 / cell)
    return lay_sprites(_of_rays(places), _of_rays(along), scale, style.half, OPACITY, style.kinds)


def _of_rays(cells: np.ndarray) -> np.ndarray:
    """Columns, rows and depths of a lamp's rays, see `front`, from places in its cells, (n, 3)."""
    return np.ascontiguousarray(cells[:, [1, 0, 2]])
