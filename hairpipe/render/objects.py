"""Picture of a mesh on a level floor, flat shaded, and of a map of a body: the hairline."""

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.triangle_tree import project, tree_over
from hairpipe.groom.painting import vertex_coat
from hairpipe.render.camera import Framing, Shot, place_camera
from hairpipe.render.film import backdrop, develop
from hairpipe.render.lights import studio
from hairpipe.render.portrait import SCENE
from hairpipe.render.shadows import cast_shadow
from hairpipe.render.skin import CLAY, shade_skin
from hairpipe.render.surface import Surface, see_body
from hairpipe.values import Body, Mesh

FLOOR = np.array([0.09, 0.095, 0.105])
"""Colour of the floor, linear."""
WIDE, TILES = 8.0, 64
"""Half the edge of the floor, over the radius of the picture, and tiles along it; those behind the eye are omitted."""
BELOW = 2e-3
"""Depth of the floor under y = 0, so that objects on it are visible, over the radius of the picture."""
NO_HAIR = np.zeros((0, 3)), np.zeros(1, np.int32)


def draw_object(mesh: Mesh, shot: Shot, framing: Framing, colour: np.ndarray) -> np.ndarray:
    """Draw a mesh of a linear colour, (3,), and its shadow on the floor at y = 0, (height, width, 3) uint8, sRGB.

    Raises BadInput where a position is not finite.
    """
    if not np.isfinite(mesh.points).all():
        raise BadInput("a point is not finite", where="mesh")
    camera = place_camera(shot, framing)
    facets = Mesh(mesh.points[mesh.triangles].reshape(-1, 3), np.arange(3 * len(mesh.triangles)).reshape(-1, 3))
    shadows = [
        cast_shadow(light, framing.target, 2 * framing.radius, *NO_HAIR, 0.0, facets) for light in studio(camera.axes)
    ]
    film = backdrop(camera.height, camera.width)
    nearest = np.full((camera.height, camera.width), np.inf)
    for thing, paint in ((_floor(framing), FLOOR), (facets, colour)):
        seen = see_body(thing, camera)
        at = seen.rows, seen.columns
        ahead = seen.depth[at] < nearest[at]
        seen = Surface(seen.rows[ahead], seen.columns[ahead], seen.points[ahead], seen.normals[ahead], seen.depth)
        at = seen.rows, seen.columns
        nearest[at] = seen.depth[at]
        film[at] = shade_skin(seen, np.tile(paint, (len(seen.rows), 1)), camera.eye, shadows)
    return develop(film, shot.grain)


def _floor(framing: Framing) -> Mesh:
    along = WIDE * framing.radius * np.linspace(-1, 1, TILES + 1)
    x, z = np.meshgrid(framing.target[0] + along, framing.target[2] + along, indexing="ij")
    points = np.stack([x, np.full_like(x, -BELOW * framing.radius), z], axis=2).reshape(-1, 3)
    i, j = (index.ravel() for index in np.indices((TILES, TILES)))
    a = i * (TILES + 1) + j
    b = a + 1
    c = a + TILES + 2
    d = a + TILES + 1
    return Mesh(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32))


PAINT, LINE = np.array([0.20, 0.045, 0.015]), np.array([0.9, 0.85, 0.35])
"""Colours of the map at 1, and at its contour of 0.5, linear."""
HALF = 0.06
"""Range of values around 0.5 that is drawn as the contour."""
ROOM = 1.6
"""Radius of the picture over that of the painted area."""


def draw_hairline(body: Body, name: str, shot: Shot) -> np.ndarray:
    """Draw a body at rest with one of its maps, (height, width, 3) uint8, sRGB; BadInput without, or if unpainted."""
    coat = vertex_coat(body, name, "map")
    mesh = body.mesh
    painted = mesh.points[body.maps[name] >= 0.5]
    if not len(painted):
        raise BadInput(f"map '{name}' is less than a half everywhere", where="map", right="a map that is painted")
    lower = painted.min(axis=0)
    upper = painted.max(axis=0)
    framing = Framing(0.5 * (lower + upper), max(0.5 * ROOM * float(np.linalg.norm(upper - lower)), 1e-3))
    camera = place_camera(shot, framing)
    shadows = [
        cast_shadow(light, framing.target, SCENE * framing.radius, *NO_HAIR, 0.0, mesh) for light in studio(camera.axes)
    ]
    surface = see_body(mesh, camera)
    film = backdrop(camera.height, camera.width)
    sites, _ = project(tree_over(mesh.points[mesh.triangles]), surface.points)
    paint = np.clip(coat(sites), 0.0, 1.0)[:, None]
    colours = np.where(np.abs(paint - 0.5) < HALF, LINE, CLAY + paint * (PAINT - CLAY))
    film[surface.rows, surface.columns] = shade_skin(surface, colours, camera.eye, shadows)
    return develop(film, shot.grain)
