"""A fast picture of the hair."""

from typing import Annotated, Literal

from hairpipe.engine import File, Time, Workspace, node
from hairpipe.render.camera import View
from hairpipe.units import Degrees, Fraction, Interval, Metres, Pixels, Suffixes
from hairpipe.values import Groom, Mesh, Normals, Strands

Place = tuple[Metres, Metres, Metres]


@node(frames="each", unvaried=("framed",))
def preview(
    hair: Strands,
    body: Mesh | None,
    normals: Normals | None,
    workspace: Workspace,
    time: Time,
    framed: Groom | None = None,
    *,
    width: Annotated[Pixels, Interval(ge=16, le=4096)] = 720,
    height: Annotated[Pixels, Interval(ge=16, le=4096)] = 720,
    view: View = "three_quarter",
    eye: Place | None = None,
    target: Place | None = None,
    fov: Annotated[Degrees, Interval(ge=1.0, le=120.0)] = 24.0,
    colour: tuple[Fraction, Fraction, Fraction] = (0.37, 0.25, 0.17),
    thickness: Annotated[float, Interval(gt=0.0, le=100.0)] = 1.0,
    curve: Literal["catmull_rom", "bspline"] = "catmull_rom",
    shading: Literal["kajiya_kay", "dual"] = "kajiya_kay",
    lambert: Fraction = 0.4,
    supersampling: Annotated[int, Interval(ge=1, le=4)] = 1,
    shadow: Literal["cube", "deep"] = "cube",
    shutter: Fraction = 0.0,
    turn: Degrees = 0.0,
) -> Annotated[File, Suffixes((".png",))]:
    """Render the hair and the body as PNG, in studio light.

    width          width of the picture
    height         height of the picture
    view           direction of view; the length of strands gives the scale, or that of the groom at `in.framed`, which
                   all variants of a wedge share; the roots give the centre
    eye            position of the camera, in place of that of `view`
    target         centre of the picture, in place of a point below the roots; fixes the camera
    fov            field of view across the shorter side
    colour         colour of the hair: red, green and blue, sRGB
    thickness      width factor of strands, over that of opaque hair at this number: large for few strands, 1 for many
    curve          curve basis: catmull_rom through the points, or bspline with the points as its control polygon, as
                   for key strands
    shading        shading of the hair: Kajiya and Kay's, or dual scattering, which lets light through pale hair
    lambert        share of surface shading (by `normals`) in the diffuse light of `kajiya_kay`; 0 without normals
    supersampling  number of samples across a pixel: 1 is fast, 2 is for stills
    shadow         method of shadows: cube (depth cube, fast) or deep (deep shadow maps, for stills)
    shutter        open share of the frame, for motion blur; cost grows with it, 0 switches blur off
    turn           rotation of the eye about the target per frame, towards the left ear, from frame 0
    """
    from dataclasses import replace
    from functools import partial

    from hairpipe.formats.pictures import write_png
    from hairpipe.groom.resampling import spline_knots
    from hairpipe.render.camera import Shot, radius_of
    from hairpipe.render.dual_scattering import shade_dual
    from hairpipe.render.film import develop, linear
    from hairpipe.render.kajiya_kay import facing_of, shade_hair
    from hairpipe.render.portrait import expose_portrait

    radius = None if framed is None else radius_of(framed.points, framed.offsets)
    shot = Shot(width, height, view, fov, eye, target, supersampling, turn * time.frame, radius)
    if curve == "bspline":
        points, velocities = (spline_knots(hull, hair.offsets) for hull in (hair.points, hair.velocities))
        hair = replace(hair, points=points, velocities=velocities)
    facing = facing_of(normals, len(hair.points), lambert)
    shade = shade_dual if shading == "dual" else partial(shade_hair, facing=facing)
    film = expose_portrait(hair, body, shot, linear(colour), thickness, shade, shutter * time.dt, shadow)
    write_png(workspace / "picture.png", develop(film, shot.grain))
    return File(workspace / "picture.png")
