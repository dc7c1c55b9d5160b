"""Picture of a map of a body: the hairline."""

import numpy as np

from hairpipe.data import Body
from hairpipe.errors import BadInput
from hairpipe.groom.painting.paint import vertex_coat
from hairpipe.render.film import backdrop, develop
from hairpipe.render.framing import Framing, Shot, place_camera
from hairpipe.render.lights import studio
from hairpipe.render.objects import NO_HAIR
from hairpipe.render.raster.surface import see_body
from hairpipe.render.shading.skin import CLAY, shade_skin
from hairpipe.render.shadows import cast_shadow
from hairpipe.spatial.closest import project
from hairpipe.spatial.triangle_tree import tree_over

PAINT, LINE = np.array([0.20, 0.045, 0.015]), np.array([0.9, 0.85, 0.35])
"""Colours of the map at 1, and at its contour of 0.5, linear."""
HALF = 0.06
"""Range of values around 0.5 that is drawn as the contour."""
ROOM, SCENE = 1.6, 1.35
"""Radius of the picture over that of the painted area, and half the edge of the cube of shadows over that."""


def draw_hairline(body: Body, name: str, shot: Shot) -> np.ndarray:
    """Draw a body at rest with one of its maps, (height, width, 3) uint8, sRGB.

    name  of the map
    Raise BadInput where the body has no such map, or nothing is painted.
    """
    coat = vertex_coat(body, name, "map")
    mesh = body.mesh
    framing = frame_paint(body, name)
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


def frame_paint(body: Body, name: str) -> Framing:
    """Frame the vertices whose value is at least 0.5; BadInput where there is none."""
    painted = body.mesh.points[body.maps[name] >= 0.5]
    if not len(painted):
        raise BadInput(f"map '{name}' is less than a half everywhere", where="map", right="a map that is painted")
    lower = painted.min(axis=0)
    upper = painted.max(axis=0)
    return Framing(0.5 * (lower + upper), max(0.5 * ROOM * float(np.linalg.norm(upper - lower)), 1e-3))
