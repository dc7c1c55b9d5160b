"""A fast picture of meshes."""

from typing import Annotated

from hairpipe.engine import File, Time, Workspace, node
from hairpipe.units import Degrees, Fraction, Gt, Interval, Metres, Pixels, Suffixes
from hairpipe.values import Mesh

Place = tuple[Metres, Metres, Metres]


@node(frames="each")
def preview_meshes(
    meshes: tuple[Mesh, ...],
    workspace: Workspace,
    time: Time,
    *,
    names: tuple[str, ...] = (),
    eye: Place = (1.5, 2.2, 3.6),
    target: Place = (0.0, 0.3, 0.0),
    radius: Annotated[Metres, Gt(0.0)] = 1.0,
    fov: Annotated[Degrees, Interval(ge=1.0, le=120.0)] = 24.0,
    width: Annotated[Pixels, Interval(ge=16, le=4096)] = 480,
    height: Annotated[Pixels, Interval(ge=16, le=4096)] = 360,
    colour: tuple[Fraction, Fraction, Fraction] = (0.75, 0.45, 0.25),
) -> Annotated[File, Suffixes((".png",))]:
    """Render meshes side by side as PNG, each on a floor at y = 0, in studio light, with the time.

    names   names of the meshes, written above them
    eye     position of the camera
    target  centre of each picture
    radius  radius of shadows about the target
    fov     field of view across the shorter side
    width   width of one mesh's picture
    height  height of one mesh's picture
    colour  colour of the meshes: red, green and blue, sRGB
    """
    import numpy as np

    from hairpipe.formats.pictures import check_names, write_side_by_side
    from hairpipe.render.camera import Framing, Shot
    from hairpipe.render.film import linear
    from hairpipe.render.portrait import draw_object

    check_names(names, len(meshes))
    shot = Shot(width, height, fov=fov, eye=eye, target=target)
    framing = Framing(np.array(target), radius)
    pictures = [draw_object(mesh, shot, framing, linear(colour)) for mesh in meshes]
    path = workspace / "picture.png"
    write_side_by_side(path, pictures, names, f"{time.frame / time.fps:.2f} s")
    return File(path)
