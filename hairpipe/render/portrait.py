"""A picture of hair on a body, in a studio."""

import numpy as np

from hairpipe.data import Mesh, Strands
from hairpipe.errors import BadInput
from hairpipe.render.camera import Camera
from hairpipe.render.film import GRAIN, backdrop, develop
from hairpipe.render.framing import Framing, Shot, frame_hair, place_camera
from hairpipe.render.lights import studio
from hairpipe.render.raster.lines import draw_strands
from hairpipe.render.raster.surface import see_body
from hairpipe.render.shading.kajiya_kay import shade_hair
from hairpipe.render.shading.scalp_tint import hair_share
from hairpipe.render.shading.skin import CLAY, shade_skin
from hairpipe.render.shadows import cast_shadow

FULLNESS = 14.0
"""Strands times drawn width, over the radius of the picture: that of 50,000 hairs of 80 um in a picture of 0.6 m."""
WIDEST = 1.6
"""What few strands are drawn with at most [pixels]."""
SCENE = 1.35
"""Half the edge of the cube in which shadows fall, over the radius of the picture."""
SCALP = 0.8
"""How far the skin takes the colour of the hair where hair grows: every strand drawn stands for many."""
NOBODY = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))


def draw_portrait(
    hair: Strands,
    body: Mesh | None,
    shot: Shot,
    colour: np.ndarray,
    thickness: float,
    facing: np.ndarray | None = None,
) -> np.ndarray:
    """Draw hair, and the body under it, (height, width, 3) uint8, sRGB.

    colour     of the hair, linear red, green and blue, (3,)
    thickness  drawn width over the width that looks full, see drawn_width
    facing     normals of hair as one body, each as long as its share of the diffuse light, (p, 3); None: no share

    Raises BadInput where there is no strand, or a position is not finite.
    """
    body = NOBODY if body is None else body
    check(hair, body)
    points = np.asarray(hair.points, float)
    framing = frame_hair(points, hair.offsets)
    camera = place_camera(shot, framing).enlarged(GRAIN)
    width = thickness * drawn_width(hair, framing, camera)
    shadows = [
        cast_shadow(light, framing.target, SCENE * framing.radius, points, hair.offsets, width, body)
        for light in studio(camera.axes)
    ]
    film = backdrop(camera.height, camera.width)
    surface = see_body(body, camera)
    share = SCALP * hair_share(surface.points, points[hair.offsets[:-1]], camera.axes)[:, None]
    film[surface.rows, surface.columns] = shade_skin(surface, CLAY + share * (0.5 * colour - CLAY), camera.eye, shadows)
    facing = np.zeros(points.shape) if facing is None else facing
    colours = shade_hair(points, hair.offsets, colour, camera.eye, shadows, facing)
    draw_strands(film, surface.depth, camera.project(points), hair.offsets, colours, width * camera.focal)
    return develop(film)


def drawn_width(hair: Strands, framing: Framing, camera: Camera) -> float:
    """Width that makes so many strands look full [m]: at least their own, and at most WIDEST pixels."""
    full = FULLNESS * framing.radius / (len(hair.offsets) - 1)
    pixel = GRAIN * float(np.linalg.norm(camera.eye - framing.target)) / camera.focal
    return max(hair.diameter, min(full, WIDEST * pixel))


def check(hair: Strands, body: Mesh) -> None:
    """Refuse what cannot be drawn."""
    if len(hair.offsets) < 2 or np.any(np.diff(hair.offsets) < 2):
        raise BadInput("no strands to draw", where="hair", right="at least one, each of two points or more")
    lost = np.flatnonzero(~np.isfinite(hair.points).all(axis=1))
    if len(lost):
        strands = np.unique(np.searchsorted(hair.offsets, lost, side="right") - 1)
        named = ", ".join(map(str, strands[:8])) + (", ..." if len(strands) > 8 else "")
        raise BadInput(f"{len(strands)} strands have points that are not finite: {named}", where="hair")
    if not np.isfinite(body.points).all():
        vertex = int(np.flatnonzero(~np.isfinite(body.points).all(axis=1))[0])
        raise BadInput(f"vertex {vertex} is not finite", where="body")
