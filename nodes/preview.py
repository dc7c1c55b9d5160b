"""A quick picture of the hair."""

from typing import Annotated, Literal

from hairpipe.data import Mesh, Normals, Strands
from hairpipe.graph import File, Time, Workspace, node
from hairpipe.render.framing import View
from hairpipe.units import Degrees, Fraction, Interval, Metres, Pixels, Suffixes

Place = tuple[Metres, Metres, Metres]


@node(frames="each")
def preview(
    hair: Strands,
    body: Mesh | None,
    normals: Normals | None,
    workspace: Workspace,
    time: Time,
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
    """PNG of the hair, and of the body where there is one, lit as in a studio.

    width          of the picture
    height         of the picture
    view           from where; the strands' length gives the scale, their roots the centre
    eye            position of the camera, instead of the one that `view` gives
    target         centre of the picture, instead of a place below the roots: keeps the camera still
    fov            field of view across the shorter side
    colour         of the hair: red, green and blue, sRGB
    thickness      of a strand, over what makes so many look full: few are drawn thick, very many as they are
    curve          through the points of the hair; or a B-spline whose control hull they are, as of key hairs
    shading        of the hair: Kajiya and Kay's; or dual scattering: physical, light comes through pale hair
    lambert        share of the diffuse light of `kajiya_kay` that is a surface's, by `normals`; without these, none
    supersampling  of the picture, across one of its pixels: 1 is fast, 2 is for stills
    shadow         from a cube of depths, quick; or from deep shadow maps, finer, for stills
    shutter        part of the frame while it is open: motion is blurred, at a cost that grows with it; 0: it is not
    turn           by which the eye goes around the target every frame, towards the left ear; it begins at frame 0
    """
    from dataclasses import replace
    from functools import partial

    from hairpipe.errors import BadInput
    from hairpipe.groom.resampling import spline_knots
    from hairpipe.io.picture import write_png
    from hairpipe.render.film import linear
    from hairpipe.render.framing import Shot
    from hairpipe.render.portrait import draw_portrait
    from hairpipe.render.shading.dual import shade_dual
    from hairpipe.render.shading.kajiya_kay import shade_hair

    shot = Shot(width, height, view, fov, eye, target, supersampling, turn * time.frame)
    if normals is not None and len(normals.vectors) != len(hair.points):
        what = f"{len(normals.vectors)} normals of {len(hair.points)} points"
        raise BadInput(what, where="in.normals", right="those that this hair carries")
    if curve == "bspline":
        points, velocities = (spline_knots(hull, hair.offsets) for hull in (hair.points, hair.velocities))
        hair = replace(hair, points=points, velocities=velocities)
    facing, path = None if normals is None else lambert * normals.vectors.astype(float), workspace / "picture.png"
    shade = shade_dual if shading == "dual" else partial(shade_hair, facing=facing)
    picture = draw_portrait(hair, body, shot, linear(colour), thickness, shade, shutter * time.dt, shadow)
    write_png(path, picture)
    return File(path)
