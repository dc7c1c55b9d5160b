"""A fast picture of particles of hair."""

from typing import TYPE_CHECKING, Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.render.camera import View
from hairpipe.units import Degrees, Fraction, Interval, Metres, Pixels, Suffixes
from hairpipe.values import Cloud, Mesh, Particles

if TYPE_CHECKING:
    from hairpipe.render.cloud import CloudStyle

Place = tuple[Metres, Metres, Metres]
Colour = tuple[Fraction, Fraction, Fraction]


def style(particles: Particles, colour: Colour, size: float) -> "CloudStyle":
    """Prepare the drawing of particles, for the whole shot."""
    from hairpipe.render.cloud import style_cloud
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
    """Render particles as billboards with streaks of hair, and the body, as PNG in studio light.

    width   width of the picture
    height  height of the picture
    view    direction of view; the length of hair gives the scale, its roots the centre
    eye     position of the camera, in place of that of `view`
    target  centre of the picture, in place of a point below the roots; fixes the camera
    fov     field of view across the shorter side
    colour  colour of the hair: red, green and blue, sRGB
    size    size factor of a billboard, over the size that covers hair at the spacing at rest
    """
    from hairpipe.formats.pictures import write_png
    from hairpipe.render.camera import Shot
    from hairpipe.render.cloud import draw_cloud

    path = workspace / "picture.png"
    write_png(path, draw_cloud(cloud, prepared, body, Shot(width, height, view, fov, eye, target)))
    return File(path)
