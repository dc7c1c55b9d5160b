"""Boxes and plates."""

from typing import Annotated

from hairpipe.data import Mesh
from hairpipe.graph import node
from hairpipe.units import Gt, Metres

Size = Annotated[Metres, Gt(0.0)]
Place = tuple[Metres, Metres, Metres]


@node(frames="once")
def make_box(*, size: tuple[Size, Size, Size] = (0.2, 0.02, 0.2), centre: Place = (0.0, 0.0, 0.0)) -> Mesh:
    """A closed box along the axes; `move_mesh` turns it.

    size    along X, Y and Z
    centre  of the box
    """
    from hairpipe.body.shapes import build_box

    return build_box(size, centre)
