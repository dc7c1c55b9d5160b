"""Picture of hair as particles, on a body, in a studio, without strands."""

from typing import NamedTuple

import numpy as np

from hairpipe.data import Cloud, Mesh, Particles
from hairpipe.errors import BadInput
from hairpipe.render.billboards.light_pass import transmittances
from hairpipe.render.billboards.sprites import Sprites, lay_sprites
from hairpipe.render.billboards.streaks import KINDS, streak_levels
from hairpipe.render.billboards.view_pass import paint
from hairpipe.render.camera import NEAR, Camera
from hairpipe.render.film import backdrop, develop
from hairpipe.render.framing import Framing, Shot, frame_hair, place_camera
from hairpipe.render.lights import studio
from hairpipe.render.portrait import NOBODY, SCALP, SCENE
from hairpipe.render.raster.surface import Sight, at_pixels, look_at_body, seen_vertices, turn_to
from hairpipe.render.shading import kajiya_kay, skin
from hairpipe.render.shading.scalp_tint import hair_share
from hairpipe.render.shadows import CELLS, apply, cells_of, front
from hairpipe.spatial.triangles import vertex_normals

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
