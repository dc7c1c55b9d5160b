"""Boxes and plates."""

from typing import Annotated

from hairpipe.engine import node
from hairpipe.units import Gt, Metres
from hairpipe.values import Mesh

Size = Annotated[Metres, Gt(0.0)]
Place = tuple[Metres, Metres, Metres]


@node(frames="once")
def make_box(*, size: tuple[Size, Size, Size] = (0.2, 0.02, 0.2), centre: Place = (0.0, 0.0, 0.0)) -> Mesh:
    """Build a closed box along the axes.

    size    lengths of the edges along X, Y and Z
    centre  centre of the box
    """
    from hairpipe.body.shapes import build_box

    return build_box(size, centre)
