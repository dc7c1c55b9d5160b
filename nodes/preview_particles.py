"""A quick picture of particles that stand for hair."""

from typing import TYPE_CHECKING, Annotated

from hairpipe.data import Cloud, Mesh, Particles
from hairpipe.graph import File, Workspace, node
from hairpipe.render.framing import View
from hairpipe.units import Degrees, Fraction, Interval, Metres, Pixels, Suffixes

if TYPE_CHECKING:
    from hairpipe.render.billboards.cloud import CloudStyle

Place = tuple[Metres, Metres, Metres]
Colour = tuple[Fraction, Fraction, Fraction]


def style(particles: Particles, colour: Colour, size: float) -> "CloudStyle":
    """Choose how particles are drawn, for the whole shot."""
    from hairpipe.render.billboards.cloud import style_cloud
    from hairpipe.render.film import linear

    return style_cloud(particles, linear(colour), size)


@node(frames="each", prepare=style)
def preview_particles(
    cloud: Cloud,
    particles: Particles,
    body: Mesh | None,
    workspace: Workspace,
    prepared: "CloudStyle",
    *,
    width: Annotated[Pixels, Interval(ge=16, le=4096)] = 720,
    height: Annotated[Pixels, Interval(ge=16, le=4096)] = 720,
    view: View = "three_quarter",
    eye: Place | None = None,
    target: Place | None = None,
    fov: Annotated[Degrees, Interval(ge=1.0, le=120.0)] = 24.0,
    colour: Colour = (0.37, 0.25, 0.17),
    size: Annotated[float, Interval(gt=0.0, le=10.0)] = 1.0,
) -> Annotated[File, Suffixes((".png",))]:
    """PNG of particles as billboards with streaks of hair, and of the body where there is one, lit as in a studio.

    width   of the picture
    height  of the picture
    view    from where; the length of the hair gives the scale, its roots the centre
    eye     position of the camera, instead of the one that `view` gives
    target  centre of the picture, instead of a place below the roots: keeps the camera still
    fov     field of view across the shorter side
    colour  of the hair: red, green and blue, sRGB
    size    of a billboard, over what covers hair evenly where particles are as far apart as at rest
    """
    from hairpipe.io.picture import write_png
    from hairpipe.render.billboards.cloud import draw_cloud
    from hairpipe.render.framing import Shot

    path = workspace / "picture.png"
    write_png(path, draw_cloud(cloud, prepared, body, Shot(width, height, view, fov, eye, target)))
    return File(path)
