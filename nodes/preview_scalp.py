"""A picture of the scalp map."""

from typing import Annotated

from hairpipe.engine import File, Workspace, node
from hairpipe.units import Interval, Pixels, Suffixes
from hairpipe.values import Body


@node(frames="once")
def preview_scalp(
    scalp: Body,
    workspace: Workspace,
    *,
    map: str = "scalp",
    width: Annotated[Pixels, Interval(ge=16, le=4096)] = 360,
    height: Annotated[Pixels, Interval(ge=16, le=4096)] = 480,
) -> Annotated[File, Suffixes((".png",))]:
    """Render a body at rest from three sides as PNG, with a painted map and its contour at one half.

    map     name of the map of the body: "scalp" marks where hair grows
    width   width of the picture of each side
    height  height of the picture
    """
    from hairpipe.formats.pictures import write_side_by_side
    from hairpipe.render.camera import Shot
    from hairpipe.render.portrait import draw_hairline

    views = ("front", "side", "back")
    path = workspace / "picture.png"
    write_side_by_side(path, [draw_hairline(scalp, map, Shot(width, height, view)) for view in views], views, map)
    return File(path)
