"""A picture of the hair by path tracing."""

from typing import Annotated

from hairpipe.data import Mesh, Strands
from hairpipe.graph import File, Time, Workspace, node
from hairpipe.render.framing import View
from hairpipe.units import Degrees, Fraction, Interval, Metres, Pixels, Suffixes

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
    """PNG of the hair, and of the body where there is one, by Blender's Cycles, in the frame and studio of `preview`.

    Needs Blender as a Python module: `pip install 'hairpipe[cycles]'`.

    width      of the picture
    height     of the picture
    view       from where; the strands' length gives the scale, their roots the centre
    eye        position of the camera, instead of the one that `view` gives
    target     centre of the picture, instead of a place below the roots: keeps the camera still
    fov        field of view across the shorter side
    melanin    pigment of the hair: 0 is white, 1 is black
    redness    share of the pigment that is red
    colour     of the hair instead of pigment: red, green and blue, sRGB
    thickness  of a strand, over what makes so many look full: few are drawn thick, very many as thick as they are
    samples    paths of light a pixel
    denoise    whether the noise that few samples leave is smoothed
    shutter    part of the frame while it is open: what moves is blurred; 0: nothing is
    """
    from hairpipe.io.picture import write_png
    from hairpipe.render.cycles.scene import Exposure, Fibre, render_hair
    from hairpipe.render.film import linear
    from hairpipe.render.framing import Shot
    from hairpipe.render.shading.fibre import pigment_colour

    shot = Shot(width, height, view, fov, eye, target)
    fibre = Fibre(thickness, pigment_colour(melanin, redness) if colour is None else linear(colour))
    exposure = Exposure(samples, denoise, shutter * time.dt)
    path = workspace / "picture.png"
    write_png(path, render_hair(hair, body, shot, fibre, exposure, workspace))
    return File(path)
