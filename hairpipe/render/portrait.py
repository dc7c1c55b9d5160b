"""Picture of hair on a body, in a studio."""

from collections.abc import Callable, Sequence

import numpy as np

from hairpipe.errors import BadInput
from hairpipe.render.camera import Camera, Framing, Shot, frame_hair, place_camera
from hairpipe.render.deep_shadow import cast_deep_shadow
from hairpipe.render.film import backdrop, develop, instants, outlines, soften
from hairpipe.render.kajiya_kay import shade_hair
from hairpipe.render.lights import Light, Shade, studio
from hairpipe.render.lines import draw_strands, lay_curves
from hairpipe.render.shadows import cast_shadow
from hairpipe.render.skin import CLAY, hair_share, shade_skin
from hairpipe.render.surface import see_body
from hairpipe.values import Mesh, Strands

FULLNESS = 14.0
"""Strands times drawn width, over the radius of the picture: that of 50,000 hairs of 80 um in a picture of 0.6 m."""
WIDEST = 1.6
"""Largest drawn width of strands [pixels]."""
SCENE = 1.35
"""Half the edge of the cube of shadows, over the radius of the picture."""
CASTERS = 250_000
"""Largest number of points that cast shadows; of more, one strand in so many casts the shadow of all."""
FINE = 200_000
"""Number of points up to which light is also computed in the middle of segments."""
SCALP = 0.8
"""Share of the hair's colour in skin where hair grows: every drawn strand represents many."""
SHADOWS = {"cube": cast_shadow, "deep": cast_deep_shadow}
Shading = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, Sequence[Shade]], np.ndarray]
"""Shading as `shade_hair`."""
NOBODY = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))


def draw_portrait(
    hair: Strands,
    body: Mesh | None,
    shot: Shot,
    colour: np.ndarray,
    thickness: float,
    shade: Shading = shade_hair,
    shutter: float = 0.0,
    shadow: str = "cube",
) -> np.ndarray:
    """Draw hair of a linear colour, (3,), and the body under it, (height, width, 3) uint8, sRGB.

    thickness  drawn width over the width that looks full, see `drawn_width`
    shutter    exposure time [s]: motion is blurred, in the light of its middle
    shadow     name of the shadow map, one of SHADOWS

    Raises BadInput where there is no strand, or a position is not finite.
    """
    return develop(expose_portrait(hair, body, shot, colour, thickness, shade, shutter, shadow), shot.grain)


def expose_portrait(
    hair: Strands,
    body: Mesh | None,
    shot: Shot,
    colour: np.ndarray,
    thickness: float,
    shade: Shading,
    shutter: float = 0.0,
    shadow: str = "cube",
) -> np.ndarray:
    """Return the light on the film, linear, (grain*height, grain*width, 3) float32; arguments as of `draw_portrait`."""
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
    if not np.isfinite(body.points).all():
        vertex = int(np.flatnonzero(~np.isfinite(body.points).all(axis=1))[0])
        raise BadInput(f"vertex {vertex} is not finite", where="body")
