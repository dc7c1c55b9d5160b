"""Pictures in a studio: hair on a body, a mesh on a level floor, and a map of a body, the hairline."""

from collections.abc import Callable, Sequence

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.geometry.triangle_tree import project, tree_over
from hairpipe.render.camera import Camera, Framing, Shot, frame_hair, place_camera
from hairpipe.render.deep_shadow import cast_deep_shadow
from hairpipe.render.film import backdrop, develop, instants, outlines, soften
from hairpipe.render.kajiya_kay import shade_hair
from hairpipe.render.lights import Light, Shade, studio
from hairpipe.render.lines import draw_strands, lay_curves
from hairpipe.render.shadows import cast_shadow
from hairpipe.render.skin import CLAY, hair_share, shade_skin
from hairpipe.render.surface import Surface, see_body
from hairpipe.values import Body, Mesh, Strands
from hairpipe.values.painting import vertex_coat

FULLNESS = 14.0
"""Strands times drawn width, over the radius of the picture: that of 50,000 hairs of 80 um in a picture of 0.6 m."""
WIDEST = 1.6  # largest drawn width of strands [pixels]
SCENE = 1.35
"""Half the edge of the cube of shadows, over the radius of the picture."""
CASTERS = 250_000  # largest number of points that cast shadows; of more, one strand in so many casts the shadow of all
FINE = 200_000  # number of points up to which light is also computed in the middle of segments
SCALP = 0.8
"""Share of the hair's colour in skin where hair grows: every drawn strand represents many."""
SHADOWS = {"cube": cast_shadow, "deep": cast_deep_shadow}
Shading = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, Sequence[Shade]], np.ndarray]
"""Shading as `shade_hair`."""
NOBODY = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))


def expose_portrait(
    hair: Strands,
    body: Mesh | None,
    shot: Shot,
    colour: np.ndarray,
    thickness: float,
    shade: Shading = shade_hair,
    shutter: float = 0.0,
    shadow: str = "cube",
) -> np.ndarray:
    """Return the light of hair and the body under it on the film, linear, (grain*height, grain*width, 3) float32.

    colour     of the hair, linear, (3,)
    thickness  drawn width over the width that looks full, see `drawn_width`
    shutter    exposure time [s]: motion is blurred, in the light of its middle
    shadow     name of the shadow map, one of SHADOWS

    Raises BadInput where there is no strand, or a position is not finite.
    """
    body = NOBODY if body is None else body
    check(hair, body)
    points = np.asarray(hair.points, float)
    framing = frame_hair(points, hair.offsets, shot.radius)
    camera = place_camera(shot, framing)
    width = thickness * drawn_width(hair, framing, camera, shot.grain)
    widths = width * relative_widths(hair)
    shadows = cast_shadows(hair, body, framing, studio(camera.axes), widths, shadow)
    film = np.zeros((camera.height, camera.width, 3), np.float32)
    fine = len(points) <= FINE
    colours = np.empty((2 * len(points), 3))
    known = np.zeros(2 * len(points), bool)
    taken = 0
    for places, moved in instants(hair, body, camera, shutter):
        surface = see_body(body, camera, moved)
        layer = backdrop(camera.height, camera.width)
        share = SCALP * hair_share(surface.points, points[hair.offsets[:-1]], camera.axes)[:, None]
        skin = CLAY + share * (0.5 * colour - CLAY)
        layer[surface.rows, surface.columns] = shade_skin(surface, skin, camera.eye, shadows)
        outline = outlines(surface.depth, camera.focal)
        bare = layer[outline]
        curves = lay_curves(camera.project(places), hair.offsets, widths * camera.focal, surface.depth)
        lit = np.zeros(2 * len(points), bool)
        for site in (0, 1, 2) if fine else (0, 2):  # ends, if fine middles, of visible segments
            lit[2 * curves.starts + site] = True
        fresh = np.flatnonzero(lit & ~known)
        colours[fresh] = shade(points, hair.offsets, fresh, colour, camera.eye, shadows)
        known[fresh] = True
        if not fine:
            colours[2 * curves.starts + 1] = 0.5 * (colours[2 * curves.starts] + colours[2 * curves.starts + 2])
        draw_strands(layer, surface.depth, curves, colours.reshape(-1, 2, 3))
        soften(layer, outline, bare)
        film += layer
        taken += 1
    return film / np.float32(taken)


def cast_shadows(
    hair: Strands, body: Mesh, framing: Framing, lights: Sequence[Light], width: float | np.ndarray, shadow: str
) -> list[Shade]:
    """Cast the shadows of hair of widths [m] and of the body from every lamp, by the shadow map of that name."""
    points = np.asarray(hair.points, float)
    every = (len(points) - 1) // CASTERS + 1  # of more, every n-th strand casts, n times as wide
    counts = np.diff(hair.offsets)
    cast = np.arange(len(counts)) % every == 0
    chosen = np.repeat(cast, counts)
    widths = every * np.broadcast_to(width, len(points))[chosen]
    casting = points[chosen], np.concatenate([[0], np.cumsum(counts[cast])]), widths
    return [SHADOWS[shadow](light, framing.target, SCENE * framing.radius, *casting, body) for light in lights]


def drawn_width(hair: Strands, framing: Framing, camera: Camera, grain: int) -> float:
    """Return the width of strands for a dense look [m]: at least their own, at most WIDEST pixels of the picture."""
    full = FULLNESS * framing.radius / (len(hair.offsets) - 1)
    pixel = grain * float(np.linalg.norm(camera.eye - framing.target)) / camera.focal
    return max(hair.diameter, min(full, WIDEST * pixel))


def relative_widths(hair: Strands) -> np.ndarray | float:
    """Return the widths of points over their mean, (p,), or 1 where they do not vary."""
    return 1.0 if hair.widths is None else hair.widths / np.float64(hair.diameter)


def check(hair: Strands, body: Mesh) -> None:
    """Raise BadInput for what cannot be drawn."""
    if len(hair.offsets) < 2 or np.any(np.diff(hair.offsets) < 2):
        raise BadInput("no strands to draw", where="hair", right="at least one, each of two points or more")
    lost = np.flatnonzero(~np.isfinite(hair.points).all(axis=1))
    if len(lost):
        strands = np.unique(np.searchsorted(hair.offsets, lost, side="right") - 1)
        named = ", ".join(map(str, strands[:8])) + (", ..." if len(strands) > 8 else "")
        raise BadInput(f"{len(strands)} strands have points that are not finite: {named}", where="hair")
    check_finite(body.points, "vertex", "body")


def check_finite(points: np.ndarray, name: str, where: str) -> None:
    """Raise BadInput for the first point, (n, 3), that is not finite."""
    lost = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(lost):
        raise BadInput(f"{name} {lost[0]} is not finite", where=where)


FLOOR = np.array([0.09, 0.095, 0.105])  # colour of the floor, linear
WIDE, TILES = 8.0, 64
"""Half the edge of the floor, over the radius of the picture, and tiles along it; those behind the eye are omitted."""
BELOW = 2e-3  # depth of the floor under y = 0, so that objects on it are visible, over the radius of the picture
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
HALF = 0.06  # range of values around 0.5 that is drawn as the contour
ROOM = 1.6  # radius of the picture over that of the painted area


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
