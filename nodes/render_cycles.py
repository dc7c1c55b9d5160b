"""A picture of the hair by path tracing."""

from typing import Annotated

from hairpipe.engine import File, Time, Workspace, node
from hairpipe.render.camera import View
from hairpipe.units import Degrees, Fraction, Interval, Metres, Pixels, Suffixes
from hairpipe.values import Mesh, Strands

Place = tuple[Metres, Metres, Metres]


@node(frames="each")
def render_cycles(
    hair: Strands,
    body: Mesh | None,
    workspace: Workspace,
    time: Time,
    *,
    width: Annotated[Pixels, Interval(ge=16, le=4096)] = 720,
    height: Annotated[Pixels, Interval(ge=16, le=4096)] = 720,
    view: View = "three_quarter",
    eye: Place | None = None,
    target: Place | None = None,
    fov: Annotated[Degrees, Interval(ge=1.0, le=120.0)] = 24.0,
    melanin: Fraction = 0.6,
    redness: Fraction = 0.7,
    colour: tuple[Fraction, Fraction, Fraction] | None = None,
    thickness: Annotated[float, Interval(gt=0.0, le=100.0)] = 1.0,
    samples: Annotated[int, Interval(ge=1, le=4096)] = 8,
    denoise: bool = True,
    shutter: Fraction = 0.0,
) -> Annotated[File, Suffixes((".png",))]:
    """Render the hair and the body as PNG with Blender's Cycles, in the frame and studio of `preview`.

    Needs Blender as a Python module: `pip install 'hairpipe[cycles]'`, with Python 3.11 or 3.13.

    width      width of the picture
    height     height of the picture
    view       direction of view; the length of strands gives the scale, their roots the centre
    eye        position of the camera, in place of that of `view`
    target     centre of the picture, in place of a point below the roots; fixes the camera
    fov        field of view across the shorter side
    melanin    pigment of the hair: 0 is white, 1 is black
    redness    share of red pigment in the pigment
    colour     colour of the hair in place of pigment: red, green and blue, sRGB
    thickness  width factor of strands, over that of opaque hair at this number: large for few strands, 1 for many
    samples    number of light paths per pixel
    denoise    removal of the noise of few samples
    shutter    open share of the frame, for motion blur; 0 switches blur off
    """
    from hairpipe.formats.pictures import write_png
    from hairpipe.render.camera import Shot
    from hairpipe.render.cycles import Exposure, Fibre, trace_hair
    from hairpipe.render.dual_scattering import pigment_colour
    from hairpipe.render.film import develop, linear

    shot = Shot(width, height, view, fov, eye, target)
    fibre = Fibre(thickness, pigment_colour(melanin, redness) if colour is None else linear(colour))
    exposure = Exposure(samples, denoise, shutter * time.dt)
    path = workspace / "picture.png"
    write_png(path, develop(trace_hair(hair, body, shot, fibre, exposure, workspace), 1))
    return File(path)
